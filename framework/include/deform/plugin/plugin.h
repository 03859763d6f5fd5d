/// The base of everything that a plugin library makes.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "deform/export.h"

namespace deform {

/// What an object remembers between steps, by name; goes into checkpoints.
class DEFORM_API Memory {
 public:
  void put(const std::string& name, std::vector<double> values);
  /// Throws InputError when the name is missing or its length is not `size`.
  [[nodiscard]] const std::vector<double>& get(const std::string& name, std::size_t size) const;
  [[nodiscard]] const std::map<std::string, std::vector<double>>& entries() const {
    return entries_;
  }

 private:
  std::map<std::string, std::vector<double>> entries_;
};

/// Base of every plugin interface. Objects without memory need neither save nor load.
///
/// `save` puts all that the object's results depend on and that is not in the scene or the State;
/// it is called between steps, before probes and outputs record the step. `load` gets the same back
/// in an object that was made from the same scene (and begun, where there is a `begin`): from there
/// on the object must do what the saved one did, to the last bit. Throws InputError, as Memory::get
/// does, when the memory is not one of its own.
class DEFORM_API Plugin {
 public:
  Plugin() = default;
  Plugin(const Plugin&) = delete;
  Plugin& operator=(const Plugin&) = delete;
  virtual ~Plugin();

  virtual void save(Memory& memory) const;
  virtual void load(const Memory& memory);

  /// Of what makes a model (energies, forces, constraints, colliders): the longest step from a time
  /// on that it stands [s]. Integrators that choose their steps take none longer. A pure
  /// function of time.
  [[nodiscard]] virtual double longest_step(double time) const;

  /// Of the same parts: the first time later than `after` [s] at which what the part does is not a
  /// smooth function of time (a load that jumps or has a corner, a path with a corner); infinite
  /// where there is none, as here. A pure function of time.
  ///
  /// The framework ends the integrator's steps there and has it start anew (Integrator::restart): a
  /// method has its order, and a load its impulse, only where steps do not reach across. At the
  /// time itself the part takes the values that hold from then on.
  [[nodiscard]] virtual double next_break(double after) const;
};

}  // namespace deform
