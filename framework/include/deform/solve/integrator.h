/// Integrators: from one recorded time to the next.
#pragma once

#include <cstdint>

#include "deform/plugin/descriptor.h"
#include "deform/solve/system.h"

namespace deform {

/// Advances a state. The scene's `step` [s] is read by the framework for every integrator.
class DEFORM_API Integrator : public Plugin {
 public:
  static constexpr PluginKind kKind = PluginKind::integrator;
  ~Integrator() override;
  /// Advances r, v and time by exactly `step` seconds, in as many substeps as it likes; prescribed
  /// components end where the constraints say.
  virtual void advance(System& system, State& state, double step) = 0;
  /// Called between two calls of `advance` where loads or supports are not smooth in time
  /// (Plugin::next_break; the framework divides the scene's step there): accelerations, and
  /// velocities of what is moved, may jump. What a method remembers of earlier steps, to go on from
  /// it, is not of the motion that follows. Methods that take each step by itself need nothing.
  virtual void restart() {}
  /// Whether it looks for equilibria, so that inertia has no say: nothing falls or swings.
  [[nodiscard]] virtual bool is_static() const { return false; }
  /// What it solves, so that a solver which a scene names and that cannot is refused
  /// before anything is written.
  enum class Solves : std::uint8_t {
    nothing,   ///< it is explicit: MassMatrix::accelerate at most
    lagged,    ///< LaggedMatrix::solve
    tangents,  ///< NewtonMatrix, ForceJacobian
  };
  [[nodiscard]] virtual Solves solves() const { return Solves::lagged; }
  /// Whether its steps end outside of colliders, friction included; else the framework calls
  /// ColliderContact::resolve after each.
  [[nodiscard]] virtual bool resolves_contacts() const { return false; }
  /// Whether a step takes coefficients from the state at its start
  /// (LaggedMatrix), so that estimators of the normal differ by what the surface
  /// moves in a step. Others evaluate forces at one state, coefficients and jets alike.
  [[nodiscard]] virtual bool lags_coefficients() const { return false; }
};

}  // namespace deform
