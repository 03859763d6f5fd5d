/// Forces and potentials of a whole model at a state.
#pragma once

#include <string>
#include <vector>

#include "deform/export.h"
#include "deform/solve/state.h"
#include "deform/solve/step_strains.h"
#include "deform/types.h"

namespace deform {

class Assembly;

/// Everything here depends on its arguments alone; results are the caller's. `strains`: null for
/// those of the state. Not thread-safe: it works in parallel itself, and keeps the geometry of the
/// states that it saw last. All throw NotFinite where some part gives a number that is not finite,
/// naming it, and Error (interrupted) where the step is to be given up (Simulation::stop_when).
class DEFORM_API Evaluator {
 public:
  explicit Evaluator(Assembly& assembly) : assembly_(&assembly) {}

  /// All forces but what ModelParts::damping times velocity takes, to f (N × 3) [N]; coefficients
  /// lagged at the same state.
  void force(const State& state, NodeVectors& f, const StepStrains* strains = nullptr) const;
  [[nodiscard]] NodeVectors force(const State& state, const StepStrains* strains = nullptr) const {
    NodeVectors f;
    force(state, f, strains);
    return f;
  }
  /// Energy of all terms and potential energy of all force fields [J].
  [[nodiscard]] double potential(const State& state, const StepStrains* strains = nullptr) const;
  /// Whose gradient the damping of materials is where its rates are measured over a step [J]; else
  /// 0.
  [[nodiscard]] double damping_potential(const State& state, const StepStrains& strains) const;
  /// (N × 3) what is no gradient of `potential` though its energy terms are: force fields without a
  /// potential, damping of materials unless that has one, averaged strains [N].
  [[nodiscard]] NodeVectors nonconservative_force(const State& state,
                                                  const StepStrains* strains = nullptr) const;
  /// Whether that can be anything but zero.
  [[nodiscard]] bool has_nonconservative_force(const StepStrains* strains = nullptr) const;
  /// (N × 3) all that damps: −ModelParts::damping times velocity, and damping of materials [N].
  [[nodiscard]] NodeVectors damping_force(const State& state) const;

  /// What has a part in the force but not in `potential`, and what has none in the tangent (or one
  /// that is not its derivative): names, by which Newton's method is known to fall short.
  [[nodiscard]] std::vector<std::string> without_potential() const;
  [[nodiscard]] std::vector<std::string> without_tangent() const;
  /// Whether all energy terms have a potential, whatever the force fields.
  [[nodiscard]] bool energies_have_potential() const;

  /// What the framework reads.
  [[nodiscard]] Assembly& assembly() const { return *assembly_; }

 private:
  Assembly* assembly_;
};

}  // namespace deform
