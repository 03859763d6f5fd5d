#include "solve/newton/stage_objective.h"

#include <algorithm>
#include <cmath>

#include "deform/geometry/characteristic_length.h"
#include "deform/parallel.h"
#include "deform/plugin/values.h"
#include "deform/solve/system.h"

#include "not_finite.h"
#include "profile/profile.h"
#include "solve/matrix/difference_step.h"
#include "solve/newton/constants.h"
#include "solve/newton/convergence.h"
#include "solve/newton/descent_direction.h"
#include "solve/system_parts.h"

namespace deform {
namespace {

/// Nodes that one task takes.
constexpr Index kRows = 2048;
/// Where no step moves anything, friction agrees with the normal forces if making it that of these
/// leaves no more than so many times the residual.
constexpr double kSameResidual = 2;
/// Of the Krylov space that a direction is looked for in, at most; and the residual that a
/// direction without a potential may leave of its equation: |F| falls along it as long as that is
/// below 1.
constexpr int kMostVectors = 30;
constexpr double kGoodEnough = 0.5;
/// Active sets of one direction, at most.
constexpr int kMostSets = 2;

}  // namespace

void StageObjective::begin(const System& system, const Stage& s, const StepStrains& strains) {
  if (system_ != &system) {
    matrix_.emplace(system);
    jacobian_.reset();
    rest_stiffness_.resize(0);
  }
  system_ = &system;
  stage_ = &s;
  strains_ = &strains;
  has_potential_ = system.evaluator().energies_have_potential();
  has_tangents_ = SystemParts::of(system).assembly.terms.have_tangents();
  has_nonconservative_ = system.evaluator().has_nonconservative_force(strains_);
  with_contacts_ = has_potential_ && system.contact().bodies() > 0;
  has_changed_ = false;
  solver_iterations_ = completed_directions_ = 0;
  size_ = deform::characteristic_length(system.rest());
  mass_ = system.mass() / (s.tau * s.tau);
  damping_ = system.damping() / s.tau;
  diagonal_ = mass_ + damping_;
  inertial_ = s.r_base + s.tau * s.v_base;
  if (with_contacts_) {
    if (rest_stiffness_.size() == 0) {
      matrix_->evaluate(system.at_rest());
      rest_stiffness_ = matrix_->mean_stiffness().cwiseMax(0);
    }
    contacts_.begin(system.contact(), s, size_, diagonal_ + rest_stiffness_);
  }
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

double StageObjective::distance_bound(double promised) const {
  return std::sqrt(std::max(promised, 0.0) / mass_.sum());
}

double StageObjective::error_allowed(const State& state) const {
  if (share_ == 0 || stage_->error_per_change == 0) return 0;
  change_ = state.r - stage_->prediction;
  return share_ * stage_->error_per_change * length(change_);
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
  if (with_contacts_) sum += contacts_.dissipation(state.r);
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

/// Forces, and the tangent.
void StageObjective::evaluate_tangent(State& state, Tangent kind, const NodeVectors* before) {
  system_->evaluator().force(state, force_, strains_);
  evaluate_matrix(state, kind, before);
}

void StageObjective::evaluate_matrix(const State& state, Tangent kind, const NodeVectors* before) {
  matrix_->evaluate(state, {.kind = kind,
                            .before = before,
                            .rate = 1 / stage_->tau,
                            .strains = strains_,
                            .for_directions = true});
  contact_tangent_.clear();
}

/// In place of what the matrix has of it.
void StageObjective::add_contact_tangent() {
  for (BlockEntry& e : contact_tangent_) e.block = -e.block;
  matrix_->add(contact_tangent_);
  contact_tangent_ = contacts_.tangent();
  matrix_->add(contact_tangent_);
}

void StageObjective::begin_contact(State& state) {
  if (!with_contacts_) return;
  (void)evaluate_residual(state);
  has_changed_ = false;
}

double StageObjective::evaluate(State& state, Tangent kind, const NodeVectors& before) {
  if (!has_potential_) return evaluate_residual(state);
  set_velocity(state);
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
  system_->constraints().reduce_force(residual_);
  has_changed_ = with_contacts_ && contacts_.react(state.r, residual_);
  return residual_.norm();
}

double StageObjective::evaluate_residual(State& state) {
  set_velocity(state);
  system_->evaluator().force(state, force_, strains_);
  return residual(state);
}

/// Where a node turns out to have come through a body, it goes on from where it came in.
bool StageObjective::accept(State& state, Tangent& kind, double norm, Ending ending) {
  if (!with_contacts_) return true;
  const bool has_new_planes = contacts_.update(state.r);
  if (has_new_planes) {
    contacts_.confine(state.r);
    set_velocity(state);
    kind = Tangent::exact;
    evaluate_tangent(state, kind, nullptr);
  }
  const double updated = residual(state);
  if (ending == Ending::correction && !has_new_planes &&
      contacts_.unsettled(mass_) <= std::max(error_, error_allowed(state)))
    return true;
  const double same =
      ending == Ending::residual || ending == Ending::correction ? 0 : kSameResidual * norm;
  return !has_new_planes && updated <= std::max(tolerance_ * scale_, same);
}

ForceJacobian& StageObjective::jacobian() {
  if (!jacobian_) jacobian_.emplace(*system_);
  return *jacobian_;
}

std::string StageObjective::find_direction(State& state, double tolerance, Tangent& kind,
                                           NodeVectors& direction) {
  if (!has_potential_) return find_direction_without_potential(state, tolerance, kind, direction);
  if (!with_contacts_) return find_descent(state, residual_, tolerance, kind, direction);
  contacts_.begin_direction();
  std::string reason;
  for (int set = 0; set < kMostSets; ++set) {
    add_contact_tangent();
    target_ = residual_;
    contacts_.add_targets(target_);
    reason = find_descent(state, target_, tolerance, kind, direction);
    if (!reason.empty() || !contacts_.revise(state.r, direction)) break;
  }
  if (reason.empty() && !(slope(direction) < 0)) {
    contacts_.drop_predicted();
    add_contact_tangent();
    reason = find_descent(state, residual_, tolerance, kind, direction);
  }
  return reason;
}

/// Along which |F| falls.
std::string StageObjective::find_direction_without_potential(State& state, double tolerance,
                                                             Tangent& kind,
                                                             NodeVectors& direction) {
  by_differences_ = true;
  if (has_tangents_) {
    if (kind == Tangent::mixed) kind = Tangent::exact;
    evaluate_matrix(state, kind, nullptr);
    by_differences_ = !find_descent(state, residual_, tolerance, kind, direction).empty() ||
                      complete(state, residual_, tolerance, direction) > kGoodEnough;
  }
  if (!by_differences_) return "";
  jacobian().evaluate(state, 1 / stage_->tau, strains_);
  const std::string reason = jacobian().factor(diagonal_);
  return reason.empty() ? jacobian().solve(residual_, direction) : reason;
}

std::string StageObjective::find_descent(State& state, const NodeVectors& b, double tolerance,
                                         Tangent& kind, NodeVectors& direction) {
  DescentDirection descent{*matrix_, *system_, b, diagonal_, tolerance};
  const auto project = [&] {
    const std::vector<BlockEntry> of_contact = std::move(contact_tangent_);
    evaluate_tangent(state, Tangent::projected, nullptr);
    contact_tangent_ = of_contact;
    matrix_->add(contact_tangent_);
  };
  std::string reason = descent.find(kind, project, direction);
  solver_iterations_ += descent.solver_iterations();
  const bool is_close = kind != Tangent::projected && residual_.norm() <= kClose * scale_;
  if (reason.empty() && has_potential_ && has_nonconservative_ && is_close)
    (void)complete(state, b, tolerance, direction);
  return reason;
}

std::string StageObjective::find_direction_again(double tolerance, NodeVectors& direction) {
  if (!has_potential_ && by_differences_) return jacobian().solve(residual_, direction);
  std::string reason = matrix_->solve_again(tolerance, residual_, direction);
  solver_iterations_ += matrix_->solver_iterations();
  return reason;
}

/// J y for the whole Jacobian J of F with what contact adds: Tᵀ((M/τ² + Γ/τ + C) y − ∂f/∂r y), the
/// last by a central difference of all forces along y, velocities moving with positions.
void StageObjective::multiply_jacobian(const State& state, const NodeVectors& y,
                                       NodeVectors& product) {
  const double farthest = y.cwiseAbs().maxCoeff();
  product.setZero(y.rows(), 3);
  if (!(farthest > 0)) return;
  const double step = kDifferenceStep * size_ / farthest;
  const auto force_at = [&](double s, NodeVectors& force) {
    displaced_.r = state.r + s * y;
    set_velocity(displaced_);
    system_->evaluator().force(displaced_, force, strains_);
  };
  force_at(step, force_ahead_);
  force_at(-step, product);
  product = (product - force_ahead_) / (2 * step);
  for (int c = 0; c < 3; ++c) product.col(c) += diagonal_.cwiseProduct(y.col(c));
  for (const BlockEntry& e : contact_tangent_) {
    product.row(e.a) += y.row(e.b) * e.block.transpose();
    if (e.a != e.b) product.row(e.b) += y.row(e.a) * e.block;
  }
  system_->constraints().reduce_force(product);
}

/// Makes a direction that solves with the symmetric tangent one that solves with the whole
/// Jacobian, which is never made: a Jacobian-free Newton–Krylov method (Knoll & Keyes 2004) whose
/// preconditioner is that tangent. Returns the residual that it leaves, relative to b; 1 where the
/// direction remains.
double StageObjective::complete(const State& state, const NodeVectors& b, double tolerance,
                                NodeVectors& direction) {
  const Span span("whole Jacobian");
  const auto multiply = [&](const NodeVectors& y, NodeVectors& product) {
    multiply_jacobian(state, y, product);
    return true;
  };
  const auto precondition = [&](const NodeVectors& v, NodeVectors& z) {
    const bool solved = matrix_->solve_again(tolerance, v, z).empty();
    solver_iterations_ += matrix_->solver_iterations();
    return solved;
  };
  NodeVectors completed = direction;
  KrylovSolution found;
  try {
    found = gmres_.solve(multiply, precondition, b,
                         {.tolerance = tolerance, .vectors = kMostVectors}, completed);
  } catch (const NotFinite&) {  // where forces end, there is no derivative
  }
  if (found.vectors > 1) ++completed_directions_;
  if (found.vectors == 0 || (has_potential_ && !(slope(completed) < 0))) return 1;
  direction = completed;
  return found.residual;
}

}  // namespace deform
