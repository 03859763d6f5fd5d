#include "solve/implicit_equation.h"

#include <algorithm>
#include <cmath>

#include "deform/geometry/characteristic_length.h"
#include "deform/parallel.h"

#include "not_finite.h"
#include "profile/profile.h"
#include "solve/asked.h"

namespace deform {
namespace {

/// Where a tangent is indefinite, this part of its mean stiffness is added to it; ten times it, ….
constexpr double kLeastShift = 1e-3;
/// Nodes that one task takes.
constexpr Index kRows = 2048;

}  // namespace

void ImplicitEquation::begin(System& system, const Stage& s) {
  system_ = &system;
  stage_ = &s;
  has_potential_ = have_potential(system);
  has_beside_ = system.has_force_beside_potential();
  with_contacts_ = has_potential_ && system.colliders() > 0;
  contacts_begun_ = false;
  size_ = characteristic_length(system.rest());
  mass_ = system.mass() / (s.tau * s.tau);
  damping_ = system.damping() / s.tau;
  diagonal_ = mass_ + damping_;
  inertial_ = s.r_base + s.tau * s.v_base;
}

void ImplicitEquation::set_velocity(State& state) const {
  state.v.resize(state.r.rows(), 3);
  parallel_blocks(state.r.rows(), kRows, [&](Index first, Index size) {
    state.v.middleRows(first, size) =
        (state.r.middleRows(first, size) - stage_->r_base.middleRows(first, size)) / stage_->tau;
  });
  state.time = stage_->time;
}

void ImplicitEquation::begin_way(State& state) {
  if (!has_potential_ || !has_beside_) return;
  set_velocity(state);
  way_ = {state.r, system_->force_beside_potential(state), 0};
}

/// By the trapezoidal rule on the straight way from the last evaluation.
double ImplicitEquation::work_to(const State& state, const NodeVectors& beside) const {
  return 0.5 * (way_.beside + beside).cwiseProduct(state.r - way_.from).sum();
}

double ImplicitEquation::incremental_potential(const State& state) {
  double sum = 0;
  for (int c = 0; c < 3; ++c) {
    sum += 0.5 * mass_.dot((state.r.col(c) - inertial_.col(c)).cwiseAbs2());
    sum += 0.5 * damping_.dot((state.r.col(c) - stage_->r_base.col(c)).cwiseAbs2());
  }
  sum += system_->potential(state) + system_->damping_potential(state);
  if (contacts_begun_) {
    contacts_.find(*system_, *stage_, state.r);
    sum += contacts_.potential();
  }
  return sum;
}

double ImplicitEquation::merit(State& state) {
  const Span span("merit");
  try {
    if (!has_potential_) return evaluated_residual(state);
    set_velocity(state);
    double sum = incremental_potential(state);
    if (has_beside_) sum -= way_.work + work_to(state, system_->force_beside_potential(state));
    return sum;
  } catch (const NotFinite&) {
    return kInfinity;
  }
}

void ImplicitEquation::evaluate_tangent(State& state, Tangent kind, const NodeVectors* before) {
  system_->evaluate_with_tangent(state, kind, before, 1 / stage_->tau,
                                 with_contacts_ ? TangentUse::any : TangentUse::directions);
  if (!with_contacts_) return;
  if (!contacts_begun_)
    contacts_.begin(*system_, diagonal_ + system_->mean_stiffness().cwiseMax(0));
  contacts_begun_ = true;
  contacts_.find(*system_, *stage_, state.r);
  contacts_.add_tangent(*system_);
}

void ImplicitEquation::evaluate(State& state, Tangent kind, const NodeVectors& before) {
  set_velocity(state);
  if (!has_potential_) return system_->evaluate(state);
  evaluate_tangent(state, kind, kind == Tangent::foreseen ? &before : nullptr);
  if (!has_beside_) return;
  const NodeVectors beside = system_->force_beside_potential(state);
  way_ = {state.r, beside, way_.work + work_to(state, beside)};
}

/// Of some nodes, what is left over; returns the sums of squares of inertia, damping and forces.
Eigen::Array3d ImplicitEquation::find_left_over(const State& state, Index first, Index size) {
  Eigen::Array3d squares = Eigen::Array3d::Zero();
  const auto mass = mass_.segment(first, size).array(),
             damping = damping_.segment(first, size).array();
  for (Index c = 0; c < 3; ++c) {
    const auto of = [&](const NodeVectors& field) {
      return field.col(c).segment(first, size).array();
    };
    const auto inertia = mass * (of(inertial_) - of(state.r));
    const auto damped = damping * (of(stage_->r_base) - of(state.r));
    const auto force = of(system_->force());
    squares += Eigen::Array3d(inertia.square().sum(), damped.square().sum(), force.square().sum());
    left_.col(c).segment(first, size).array() = inertia + damped + force;
  }
  return squares;
}

double ImplicitEquation::residual(const State& state) {
  const Index nodes = state.r.rows();
  left_.resize(nodes, 3);
  squares_.resize(3, (nodes + kRows - 1) / kRows);
  parallel_blocks(nodes, kRows, [&](Index first, Index size) {
    squares_.col(first / kRows) = find_left_over(state, first, size);
  });
  scale_ = std::sqrt(squares_.rowwise().sum().maxCoeff());
  if (contacts_begun_) contacts_.add_force(left_);
  system_->reduce_force(left_);
  return left_.norm();
}

double ImplicitEquation::evaluated_residual(State& state) {
  set_velocity(state);
  system_->evaluate(state);
  if (contacts_begun_) contacts_.find(*system_, *stage_, state.r);
  return residual(state);
}

double ImplicitEquation::update_contacts(State& state, Tangent& kind) {
  has_new_planes_ = contacts_.update(*system_, *stage_, state.r);
  if (has_new_planes_) {
    kind = Tangent::exact;
    evaluate_tangent(state, kind, nullptr);
  }
  return residual(state);
}

std::string ImplicitEquation::find_direction(State& state, double tolerance, Tangent& kind,
                                             NodeVectors& direction) {
  if (!has_potential_) {
    system_->evaluate_with_jacobian(state, 1 / stage_->tau);
    const std::string reason = system_->factor_jacobian(diagonal_);
    return reason.empty() ? system_->solve_jacobian(left_, direction) : reason;
  }
  const auto solve = [&](const NodeValues& d) {
    return system_->solve_tangent_to(tolerance, d, left_, direction);
  };
  std::string reason = solve(diagonal_);
  if (reason.empty()) return "";
  if (kind != Tangent::projected) {
    kind = Tangent::projected;
    evaluate_tangent(state, kind, nullptr);
    reason = solve(diagonal_);
  }
  if (reason.empty()) return "";
  // Loads that follow the surface are in it as they are: with as much stiffness as it takes.
  const NodeValues mean = system_->mean_stiffness().cwiseMax(0);
  for (double more = kLeastShift; !reason.empty() && more <= 1; more *= 10)
    reason = solve(diagonal_ + more * mean);
  return reason;
}

std::string ImplicitEquation::find_direction_again(double tolerance, NodeVectors& direction) {
  return system_->solve_tangent_again(tolerance, left_, direction);
}

bool ImplicitEquation::find_full_direction(State& state, NodeVectors& direction) {
  if (contacts_begun_ && !contacts_.touching().empty()) return false;  // not in the Jacobian
  if (!has_jacobian_solver_) return false;
  try {
    system_->evaluate_with_jacobian(state, 1 / stage_->tau);
    return system_->factor_jacobian(diagonal_).empty() &&
           system_->solve_jacobian(left_, direction).empty() && slope(direction) < 0;
  } catch (const InputError&) {  // the scene names a solver that does not take such a matrix
    has_jacobian_solver_ = false;
    return false;
  }
}

}  // namespace deform
