/// The equation of a stage: what is left over of it, its incremental potential, Newton's
/// directions.
#pragma once

#include <string>

#include "deform/solve/implicit_stage.h"

#include "solve/contact_multipliers.h"

namespace deform {

class ImplicitEquation {
 public:
  /// Both must live as long as the equation is used; contact forces remain from stage to stage.
  void begin(System& system, const Stage& stage);

  /// Of all energies: without one, what a search makes smaller is the residual, and directions are
  /// by differences of the force.
  [[nodiscard]] bool has_potential() const { return has_potential_; }
  /// Of all forces.
  [[nodiscard]] bool is_gradient() const { return has_potential_ && !has_beside_; }
  [[nodiscard]] bool averages_strains() const { return stage_->averages_strains; }
  [[nodiscard]] bool has_contacts() const { return with_contacts_; }
  /// Of the surface [m].
  [[nodiscard]] double size() const { return size_; }

  /// Makes v and the time of a state those of the stage at its r.
  void set_velocity(State& state) const;
  /// What searches make smaller: Φ, less the work of the forces without a potential on the way
  /// taken; infinite where it cannot be evaluated.
  [[nodiscard]] double merit(State& state);
  /// Begins the way along which that work is counted.
  void begin_way(State& state);
  /// Evaluates forces and tangent at a state, to which the way then leads; `before`: positions
  /// before the last step, for Tangent::foreseen.
  void evaluate(State& state, Tangent kind, const NodeVectors& before);
  /// |Tᵀ(f − M (v − v_base)/τ − Γ v)| at the state of the last evaluation [N].
  [[nodiscard]] double residual(const State& state);
  /// Evaluates forces alone; the residual.
  [[nodiscard]] double evaluated_residual(State& state);
  /// Of forces at work in the last residual [N].
  [[nodiscard]] double scale() const { return scale_; }
  /// Makes contact forces those of the last evaluation; where a node turns out to have come through
  /// a body, evaluates the exact tangent anew, and `kind` says so. Returns the residual with them.
  [[nodiscard]] double update_contacts(State& state, Tangent& kind);
  /// Whether the last update has found such nodes.
  [[nodiscard]] bool has_new_planes() const { return has_new_planes_; }

  /// Newton's direction from the state of the last evaluation, by its tangent; where that is not
  /// positive definite by the projected one, or that and more. Φ falls along it. `tolerance`: part
  /// of its error that an iterative solver may leave. `kind` becomes what it is of. Returns "" or
  /// why there is none.
  [[nodiscard]] std::string find_direction(State& state, double tolerance, Tangent& kind,
                                           NodeVectors& direction);
  /// From the last residual, by the tangent of the last direction.
  [[nodiscard]] std::string find_direction_again(double tolerance, NodeVectors& direction);
  /// As `find_direction`, by the Jacobian of all forces, of which the tangent knows but a symmetric
  /// part; false where that is no descent.
  [[nodiscard]] bool find_full_direction(State& state, NodeVectors& direction);
  /// Φ's change by a unit step in a direction from the last evaluation [J].
  [[nodiscard]] double slope(const NodeVectors& direction) const {
    return -left_.cwiseProduct(direction).sum();
  }

  /// Where a way has come to, to go back to.
  struct Way {
    NodeVectors from;    // of the last evaluation
    NodeVectors beside;  // force without a potential there
    double work = 0;     // done by it until there [J]
  };
  [[nodiscard]] const Way& way() const { return way_; }
  void go_back_to(const Way& way) { way_ = way; }

  [[nodiscard]] ContactMultipliers& contacts() { return contacts_; }
  [[nodiscard]] const ContactMultipliers& contacts() const { return contacts_; }

 private:
  [[nodiscard]] double incremental_potential(const State& state);
  [[nodiscard]] double work_to(const State& state, const NodeVectors& beside) const;
  void evaluate_tangent(State& state, Tangent kind, const NodeVectors* before);
  [[nodiscard]] Eigen::Array3d find_left_over(const State& state, Index first, Index size);

  System* system_ = nullptr;
  const Stage* stage_ = nullptr;
  ContactMultipliers contacts_;
  bool has_potential_ = true, has_beside_ = false;
  bool with_contacts_ = false, contacts_begun_ = false, has_new_planes_ = false;
  bool has_jacobian_solver_ = true;  // as far as is known
  double size_ = 0, scale_ = 0;
  NodeValues mass_, damping_;  // M/τ², Γ/τ [N/m]
  NodeValues diagonal_;        // their sum
  NodeVectors inertial_;       // r_base + τ v_base
  NodeVectors left_;           // what is left over [N]
  Eigen::Array3Xd squares_;    // sums of squares of some nodes, [N²]
  Way way_;
};

}  // namespace deform
