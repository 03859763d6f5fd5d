#include "solve/newton/stage_objective.h"

#include <algorithm>
#include <cmath>

#include "deform/geometry/characteristic_length.h"
#include "deform/parallel.h"
#include "deform/plugin/values.h"
#include "deform/solve/system.h"

#include "not_finite.h"
#include "profile/profile.h"
#include "solve/newton/descent_direction.h"

namespace deform {
namespace {

/// Nodes that one task takes.
constexpr Index kRows = 2048;
/// Where no step moves anything, contact forces agree if making them the multipliers leaves no more
/// than so many times the residual.
constexpr double kSameResidual = 2;

}  // namespace

void StageObjective::begin(const System& system, const Stage& s, const StepStrains& strains) {
  if (system_ != &system) {
    matrix_.emplace(system);
    jacobian_.reset();
  }
  system_ = &system;
  stage_ = &s;
  strains_ = &strains;
  has_potential_ = system.evaluator().energies_have_potential();
  has_nonconservative_ = system.evaluator().has_nonconservative_force(strains_);
  with_contacts_ = has_potential_ && system.contact().bodies() > 0;
  contacts_begun_ = false;
  solver_iterations_ = 0;
  size_ = deform::characteristic_length(system.rest());
  mass_ = system.mass() / (s.tau * s.tau);
  damping_ = system.damping() / s.tau;
  diagonal_ = mass_ + damping_;
  inertial_ = s.r_base + s.tau * s.v_base;
}

void StageObjective::set_velocity(State& state) const {
  state.v.resize(state.r.rows(), 3);
  parallel_blocks(state.r.rows(), kRows, [&](Index first, Index size) {
    state.v.middleRows(first, size) =
        (state.r.middleRows(first, size) - stage_->r_base.middleRows(first, size)) / stage_->tau;
  });
  state.time = stage_->time;
}

double StageObjective::length(const NodeVectors& displacement) const {
  return root_mean_square(displacement, system_->mass());
}

void StageObjective::begin_path(State& state) {
  if (!has_potential_ || !has_nonconservative_) return;
  set_velocity(state);
  path_ = {state.r, system_->evaluator().nonconservative_force(state, strains_), 0};
}

/// By the trapezoidal rule on the straight path from the last evaluation.
double StageObjective::work_to(const State& state, const NodeVectors& force) const {
  return 0.5 * (path_.force + force).cwiseProduct(state.r - path_.to).sum();
}

double StageObjective::incremental_potential(const State& state) {
  double sum = 0;
  for (int c = 0; c < 3; ++c) {
    sum += 0.5 * mass_.dot((state.r.col(c) - inertial_.col(c)).cwiseAbs2());
    sum += 0.5 * damping_.dot((state.r.col(c) - stage_->r_base.col(c)).cwiseAbs2());
  }
  const Evaluator& evaluator = system_->evaluator();
  sum += evaluator.potential(state, strains_) + evaluator.damping_potential(state, *strains_);
  if (contacts_begun_) {
    contacts_.find(*stage_, state.r);
    sum += contacts_.potential();
  }
  return sum;
}

double StageObjective::merit(State& state) {
  const Span span("merit");
  try {
    if (!has_potential_) return evaluate_residual(state);
    set_velocity(state);
    double sum = incremental_potential(state);
    if (has_nonconservative_)
      sum -=
          path_.work + work_to(state, system_->evaluator().nonconservative_force(state, strains_));
    return sum;
  } catch (const NotFinite&) {
    return kInfinity;
  }
}

void StageObjective::evaluate_tangent(State& state, Tangent kind, const NodeVectors* before) {
  system_->evaluator().force(state, force_, strains_);
  matrix_->evaluate(state, {.kind = kind,
                            .before = before,
                            .rate = 1 / stage_->tau,
                            .strains = strains_,
                            .for_directions = !with_contacts_});
  if (!with_contacts_) return;
  if (!contacts_begun_)
    contacts_.begin(system_->contact(), diagonal_ + matrix_->mean_stiffness().cwiseMax(0));
  contacts_begun_ = true;
  contacts_.find(*stage_, state.r);
  matrix_->add(contacts_.tangent());
}

double StageObjective::evaluate(State& state, Tangent kind, const NodeVectors& before) {
  set_velocity(state);
  if (!has_potential_) {
    system_->evaluator().force(state, force_, strains_);
    return residual(state);
  }
  const bool is_mixed = kind == Tangent::mixed && before.rows() > 0;
  evaluate_tangent(state, kind, is_mixed ? &before : nullptr);
  if (has_nonconservative_) {
    const NodeVectors force = system_->evaluator().nonconservative_force(state, strains_);
    path_ = {state.r, force, path_.work + work_to(state, force)};
  }
  return residual(state);
}

/// Of some nodes, F; returns the sums of squares of inertia, damping and forces.
Eigen::Array3d StageObjective::find_residual(const State& state, Index first, Index size) {
  Eigen::Array3d squares = Eigen::Array3d::Zero();
  const auto mass = mass_.segment(first, size).array(),
             damping = damping_.segment(first, size).array();
  for (Index c = 0; c < 3; ++c) {
    const auto of = [&](const NodeVectors& field) {
      return field.col(c).segment(first, size).array();
    };
    const auto inertia = mass * (of(inertial_) - of(state.r));
    const auto damped = damping * (of(stage_->r_base) - of(state.r));
    const auto force = of(force_);
    squares += Eigen::Array3d(inertia.square().sum(), damped.square().sum(), force.square().sum());
    residual_.col(c).segment(first, size).array() = inertia + damped + force;
  }
  return squares;
}

double StageObjective::residual(const State& state) {
  const Index nodes = state.r.rows();
  residual_.resize(nodes, 3);
  squares_.resize(3, (nodes + kRows - 1) / kRows);
  parallel_blocks(nodes, kRows, [&](Index first, Index size) {
    squares_.col(first / kRows) = find_residual(state, first, size);
  });
  scale_ = std::sqrt(squares_.rowwise().sum().maxCoeff());
  if (contacts_begun_) contacts_.add_force(residual_);
  system_->constraints().reduce_force(residual_);
  return residual_.norm();
}

double StageObjective::evaluate_residual(State& state) {
  set_velocity(state);
  system_->evaluator().force(state, force_, strains_);
  if (contacts_begun_) contacts_.find(*stage_, state.r);
  return residual(state);
}

/// Where a node turns out to have come through a body, the exact tangent is evaluated anew.
bool StageObjective::accept(State& state, Tangent& kind, double norm, Ending ending) {
  if (!with_contacts_) return true;
  const bool has_new_planes = contacts_.update(*stage_, state.r);
  if (has_new_planes) {
    kind = Tangent::exact;
    evaluate_tangent(state, kind, nullptr);
  }
  const double updated = residual(state);
  const double same = ending == Ending::residual ? 0 : kSameResidual * norm;
  return !has_new_planes && updated <= std::max(tolerance_ * scale_, same);
}

ForceJacobian& StageObjective::jacobian() {
  if (!jacobian_) jacobian_.emplace(*system_);
  return *jacobian_;
}

std::string StageObjective::find_direction(State& state, double tolerance, Tangent& kind,
                                           NodeVectors& direction) {
  if (!has_potential_) {
    jacobian().evaluate(state, 1 / stage_->tau, strains_);
    const std::string reason = jacobian().factor(diagonal_);
    return reason.empty() ? jacobian().solve(residual_, direction) : reason;
  }
  DescentDirection descent{*matrix_, *system_, residual_, diagonal_, tolerance};
  std::string reason = descent.find(
      kind, [&] { evaluate_tangent(state, Tangent::projected, nullptr); }, direction);
  solver_iterations_ += descent.solver_iterations();
  return reason;
}

std::string StageObjective::find_direction_again(double tolerance, NodeVectors& direction) {
  std::string reason = matrix_->solve_again(tolerance, residual_, direction);
  solver_iterations_ += matrix_->solver_iterations();
  return reason;
}

bool StageObjective::find_full_direction(State& state, NodeVectors& direction) {
  if (is_gradient()) return false;
  if (contacts_begun_ && !contacts_.active_nodes().empty()) return false;  // not in the Jacobian
  if (!has_jacobian_solver_) return false;
  try {
    jacobian().evaluate(state, 1 / stage_->tau, strains_);
    return jacobian().factor(diagonal_).empty() && jacobian().solve(residual_, direction).empty() &&
           slope(direction) < 0;
  } catch (const InputError&) {  // the scene names a solver that does not take such a matrix
    has_jacobian_solver_ = false;
    return false;
  }
}

}  // namespace deform
