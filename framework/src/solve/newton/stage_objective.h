/// The equation of a stage of an implicit step.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "deform/solve/force_jacobian.h"
#include "deform/solve/implicit_stage.h"
#include "deform/solve/newton.h"
#include "deform/solve/newton_matrix.h"

#include "solve/contact/active_contacts.h"
#include "solve/matrix/flexible_gmres.h"

namespace deform {

/// Residual F = f − M (v − v_base)/τ − Γ v with contact forces, tied components transposed (Tᵀ);
/// merit Φ, the incremental potential, less the work of forces without a potential along the
/// path taken; or |F| where some energy has no potential.
class StageObjective final : public Objective {
 public:
  /// All must live as long as the stage is solved.
  void begin(const System& system, const Stage& stage, const StepStrains& strains);

  [[nodiscard]] bool has_potential() const override { return has_potential_; }
  /// Of all forces.
  [[nodiscard]] bool is_gradient() const { return has_potential_ && !has_nonconservative_; }
  [[nodiscard]] bool has_contacts() const { return with_contacts_; }

  /// Makes v and the time of a state those of the stage at its r.
  void set_velocity(State& state) const;
  /// Begins the path along which work is counted.
  void begin_path(State& state);
  /// Of the linear solver, since the stage began.
  [[nodiscard]] long solver_iterations() const { return solver_iterations_; }
  /// Directions since the stage began that took more of the Jacobian than its symmetric part.
  [[nodiscard]] long completed_directions() const { return completed_directions_; }

  [[nodiscard]] double merit(State& state) override;
  [[nodiscard]] double evaluate(State& state, Tangent kind, const NodeVectors& before) override;
  [[nodiscard]] double evaluate_residual(State& state) override;
  [[nodiscard]] double scale() const override { return scale_; }
  [[nodiscard]] std::string find_direction(State& state, double tolerance, Tangent& kind,
                                           NodeVectors& direction) override;
  [[nodiscard]] std::string find_direction_again(double tolerance, NodeVectors& direction) override;
  [[nodiscard]] double slope(const NodeVectors& direction) const override {
    return -residual_.cwiseProduct(direction).sum();
  }
  [[nodiscard]] double characteristic_length() const override { return size_; }
  /// Φ's second derivatives are those of its inertia, M/τ², or more, where forces are stable.
  [[nodiscard]] double distance_bound(double promised) const override;
  [[nodiscard]] double error_allowed(const State& state) const override;
  /// Root mean square over the mass.
  [[nodiscard]] double length(const NodeVectors& displacement) const override;
  [[nodiscard]] bool has_kinks() const override { return with_contacts_ && contacts_.any(); }
  void confine(State& state) override {
    if (with_contacts_) contacts_.confine(state.r);
  }
  [[nodiscard]] bool has_changed() const override { return has_changed_; }
  /// Gives friction its limits, as far as a guess tells them.
  void begin_contact(State& state);
  /// Makes friction that of the last evaluation's normal forces: whether it is what it must be.
  [[nodiscard]] bool accept(State& state, Tangent& kind, double norm, Ending ending) override;
  [[nodiscard]] bool is_fixed() const override { return !with_contacts_; }
  [[nodiscard]] bool may_go_round() const override {
    return stage_->averages_strains && !with_contacts_;
  }
  void mark() override { marked_ = path_; }
  void return_to_mark() override { path_ = marked_; }

  /// What Newton's method may leave: of the residual, relative to the scale; of the solution, as
  /// `length` has it [m], and as a part of the step's own error.
  void set_limits(double tolerance, double error, double share) {
    tolerance_ = tolerance, error_ = error, share_ = share;
  }
  [[nodiscard]] ActiveContacts& contacts() { return contacts_; }
  [[nodiscard]] const ActiveContacts& contacts() const { return contacts_; }

 private:
  /// The path that was taken to the last evaluation.
  struct WorkPath {
    NodeVectors to;     // positions there
    NodeVectors force;  // non-conservative, there
    double work = 0;    // done by it until there [J]
  };
  [[nodiscard]] double incremental_potential(const State& state);
  [[nodiscard]] double work_to(const State& state, const NodeVectors& force) const;
  void evaluate_tangent(State& state, Tangent kind, const NodeVectors* before);
  void evaluate_matrix(const State& state, Tangent kind, const NodeVectors* before);
  void add_contact_tangent();
  [[nodiscard]] std::string find_descent(State& state, const NodeVectors& b, double tolerance,
                                         Tangent& kind, NodeVectors& direction);
  [[nodiscard]] double complete(const State& state, const NodeVectors& b, double tolerance,
                                NodeVectors& direction);
  [[nodiscard]] std::string find_direction_without_potential(State& state, double tolerance,
                                                             Tangent& kind, NodeVectors& direction);
  void multiply_jacobian(const State& state, const NodeVectors& y, NodeVectors& product);
  [[nodiscard]] double residual(const State& state);
  [[nodiscard]] Eigen::Array3d find_residual(const State& state, Index first, Index size);
  [[nodiscard]] ForceJacobian& jacobian();

  const System* system_ = nullptr;
  const Stage* stage_ = nullptr;
  const StepStrains* strains_ = nullptr;
  std::optional<NewtonMatrix> matrix_;
  std::optional<ForceJacobian> jacobian_;  // made when first needed
  ActiveContacts contacts_;
  NodeValues rest_stiffness_;                // (N) of nodes, of the surface at rest [N/m]
  std::vector<BlockEntry> contact_tangent_;  // what the matrix has of it
  bool has_potential_ = true, has_nonconservative_ = false;
  bool has_tangents_ = true;     // of all energies, exact or approximate
  bool by_differences_ = false;  // the last direction
  bool with_contacts_ = false, has_changed_ = false;
  double tolerance_ = 0, error_ = 0, share_ = 0;  // limits
  double size_ = 0, scale_ = 0;
  long solver_iterations_ = 0, completed_directions_ = 0;
  NodeValues mass_, damping_;  // M/τ², Γ/τ [N/m]
  NodeValues diagonal_;        // their sum
  NodeVectors inertial_;       // r_base + τ v_base
  NodeVectors force_;          // f
  NodeVectors residual_;       // F
  NodeVectors target_;         // F and what predicted contacts want
  FlexibleGmres gmres_;
  State displaced_;             // for products with the Jacobian …
  NodeVectors force_ahead_;     // … and the force ahead
  mutable NodeVectors change_;  // from the prediction; kept for its memory
  Eigen::Array3Xd squares_;     // sums of squares of some nodes, [N²]
  WorkPath path_, marked_;
};

}  // namespace deform
