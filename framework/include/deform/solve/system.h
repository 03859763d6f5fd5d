/// The discretised equation of motion (16), assembled: what integrators, probes and outputs see of
/// a model.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "deform/export.h"
#include "deform/solve/collider_contact.h"
#include "deform/solve/constraint_set.h"
#include "deform/solve/evaluator.h"
#include "deform/solve/mass_matrix.h"
#include "deform/solve/model_parts.h"
#include "deform/solve/state.h"
#include "deform/solve/step_report.h"
#include "deform/solve/term_evaluator.h"
#include "deform/surface/surface.h"
#include "deform/types.h"

namespace deform {

class SystemParts;

/// Owns a model's parts, and what evaluates and moves them. All results have the same bits at any
/// number of threads, and depend on the arguments of a call alone. Matrices are whose they serve:
/// LaggedMatrix, NewtonMatrix, ForceJacobian.
class DEFORM_API System {
 public:
  explicit System(ModelParts parts);
  ~System();
  System(const System&) = delete;
  System& operator=(const System&) = delete;

  [[nodiscard]] Index nodes() const;
  /// N and the number of scalar unknowns: rows of a state's positions.
  [[nodiscard]] Index rows() const;
  /// Rest positions, scalar unknowns as they are at first; no velocity.
  [[nodiscard]] State at_rest() const;
  [[nodiscard]] const std::vector<ScalarUnknown>& scalars() const;
  [[nodiscard]] const Surface& surface() const;
  [[nodiscard]] const NodeVectors& rest() const;
  [[nodiscard]] const NodeValues& areas() const;
  /// (rows) [kg], [N·s/m].
  [[nodiscard]] const NodeValues& mass() const;
  [[nodiscard]] const NodeValues& damping() const;
  [[nodiscard]] const std::vector<Named<EnergyTerm>>& energies() const;

  [[nodiscard]] const Evaluator& evaluator() const;
  [[nodiscard]] const TermEvaluator& terms() const;
  [[nodiscard]] const ConstraintSet& constraints() const;
  [[nodiscard]] const ColliderContact& contact() const;
  [[nodiscard]] const MassMatrix& mass_matrix() const;

  /// The longest step from a time on that every part of the model stands [s].
  [[nodiscard]] double longest_step(double time) const;
  /// The first time later than `after` at which some part of the model is not smooth in time [s];
  /// infinite where there is none. Throws PluginFailure where one names an earlier time.
  [[nodiscard]] double next_break(double after) const;

  /// Says that a step starts here: its report is emptied, and what iterative solvers keep is made
  /// anew.
  void begin_step();
  /// Emptied by begin_step; integrators write it.
  [[nodiscard]] StepReport& step_report();
  [[nodiscard]] const StepReport& step_report() const;
  /// Why the linear solver in use is the one in use.
  [[nodiscard]] const std::string& solver_choice() const;

 private:
  friend class SystemParts;  // what the framework itself reads

  std::unique_ptr<SystemParts> parts_;
};

/// Root mean square of a field (N × 3) over the mass (N).
[[nodiscard]] DEFORM_API double root_mean_square(const NodeVectors& field, const NodeValues& mass);

}  // namespace deform
