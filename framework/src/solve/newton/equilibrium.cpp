#include "deform/solve/equilibrium.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "deform/geometry/characteristic_length.h"
#include "deform/solve/force_jacobian.h"
#include "deform/solve/newton.h"

#include "not_finite.h"
#include "solve/newton/constants.h"
#include "solve/newton/descent_direction.h"

namespace deform {
namespace {

/// Whole Newton steps before a line search is tried.
constexpr std::int64_t kMostWholeSteps = 25;
/// No step is longer than so many characteristic lengths.
constexpr double kFarthest = 2;
/// Forces that differ by less than this factor are of one kind.
constexpr double kOfTheSameKind = 100;
/// Of the residual at a load step's start: what a residual can be measured by at least.
constexpr double kOfTheStart = 1e-3;

}  // namespace

/// F = f − (1 − λ) f0 without what is held; Φ = Π + (1 − λ) f0·r.
class Equilibrium::Impl final : public Objective {
 public:
  explicit Impl(EquilibriumSettings s) : settings(s) {}

  void begin(System& of, const State& from, double to);
  [[nodiscard]] std::string solve(double part, State& state);
  [[nodiscard]] std::string solve_linear(State& state);

  [[nodiscard]] bool has_potential() const override { return has_potential_; }
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
  /// What is longer leads out of all bounds.
  [[nodiscard]] double step_limit(const Path& path) override {
    return kFarthest * size_ / std::max(path.length(), 1e-300);
  }
  [[nodiscard]] double characteristic_length() const override { return size_; }
  [[nodiscard]] bool accept(State& state, Tangent& kind, double norm, Ending ending) override;

  std::optional<NewtonMatrix> matrix;

 private:
  void place_prescribed(State& state) const;
  [[nodiscard]] double find_residual();
  [[nodiscard]] std::optional<double> unbalanced(double rounding) const;
  [[nodiscard]] bool release(const State& state);
  [[nodiscard]] std::string what_is_free() const;

  EquilibriumSettings settings;
  System* system_ = nullptr;
  std::optional<Newton> newton_;
  std::optional<ForceJacobian> jacobian_;
  std::vector<Freedom> held_;  // so that the surface does not move as a rigid body
  std::vector<Freedom> jacobian_held_;
  bool has_potential_ = true;
  bool has_released_ = false;  // the last search for an equilibrium ended with other held_
  double end_ = 0, lambda_ = 1, size_ = 0, scale_ = 0;
  double start_residual_ = 0;  // of a load step, before its first iteration; 0: not known yet
  NodeValues zero_;
  NodeVectors start_, target_, first_force_, force_, residual_;
};

void Equilibrium::Impl::begin(System& of, const State& from, double to) {
  if (system_ != &of) {
    newton_.emplace(of);
    matrix.emplace(of);
    jacobian_.reset();
  }
  system_ = &of;
  const Evaluator& evaluator = of.evaluator();
  has_potential_ = evaluator.without_potential().empty() && evaluator.without_tangent().empty();
  zero_ = NodeValues::Zero(of.rows());
  end_ = to;
  start_ = target_ = from.r;
  of.constraints().prescribe(end_, target_);
  State loaded = from;
  loaded.time = end_;
  evaluator.force(loaded, first_force_);
  held_ = matrix->hold_rigid_motions({from.r, NodeVectors::Zero(of.rows(), 3), end_});
  start_residual_ = 0;
  size_ = deform::characteristic_length(start_.topRows(of.nodes()));
}

/// Prescribed components where they are at a part of the load, what is tied behind them.
void Equilibrium::Impl::place_prescribed(State& state) const {
  for (int c = 0; c < 3; ++c)
    for (Index a = 0; a < start_.rows(); ++a)
      if (system_->constraints().reduction().prescribed(a, c))
        state.r(a, c) = start_(a, c) + lambda_ * (target_(a, c) - start_(a, c));
  system_->constraints().follow_ties(state.r);
}

std::string Equilibrium::Impl::solve(double part, State& state) {
  lambda_ = part;
  state.time = end_;
  if (has_released_) {
    held_ = matrix->hold_rigid_motions({state.r, NodeVectors::Zero(state.r.rows(), 3), end_});
    has_released_ = false;
  }
  place_prescribed(state);
  start_residual_ = 0;
  return newton_->solve(*this,
                        {.tolerance = settings.tolerance,
                         .iterations = kMostWholeSteps + settings.iterations,
                         .nonmonotone_steps = std::min(kMostWholeSteps, settings.iterations),
                         .watches = false,
                         .rotates = false},
                        0, state, system_->step_report());
}

double Equilibrium::Impl::merit(State& state) {
  try {
    if (!has_potential_) return evaluate_residual(state);
    return system_->evaluator().potential(state) +
           (1 - lambda_) * first_force_.cwiseProduct(state.r).sum();
  } catch (const NotFinite&) {
    return kInfinity;
  }
}

double Equilibrium::Impl::evaluate(State& state, Tangent kind, const NodeVectors& before) {
  system_->evaluator().force(state, force_);
  if (has_potential_)
    matrix->evaluate(state,
                     {.kind = before.rows() > 0 || kind != Tangent::mixed ? kind : Tangent::exact,
                      .before = before.rows() > 0 ? &before : nullptr});
  const double norm = find_residual();
  if (start_residual_ == 0) start_residual_ = norm;
  return norm;
}

double Equilibrium::Impl::evaluate_residual(State& state) {
  system_->evaluator().force(state, force_);
  return find_residual();
}

/// Tᵀ(f − (1 − λ) f0), without what is held. The forces at work are the load and, at the same
/// state, what constraints must hold against; where both vanish (a surface carried elsewhere), a
/// part of what there was before the first iteration.
double Equilibrium::Impl::find_residual() {
  residual_ = force_ - (1 - lambda_) * first_force_;
  scale_ = std::max({first_force_.norm(), residual_.norm(), kOfTheStart * start_residual_});
  system_->constraints().reduce_force(residual_);
  for (const Freedom& f : held_) residual_(f.node, f.component) = 0;
  return residual_.norm();
}

std::string Equilibrium::Impl::find_direction(State& state, double /*tolerance*/, Tangent& kind,
                                              NodeVectors& direction) {
  if (has_potential_) {
    const auto project = [&] { matrix->evaluate(state, {.kind = Tangent::projected}); };
    return DescentDirection(*matrix, *system_, residual_, zero_, 0).find(kind, project, direction);
  }
  if (!jacobian_ || jacobian_held_ != held_) jacobian_.emplace(*system_, held_);
  jacobian_held_ = held_;
  jacobian_->evaluate(state);
  const std::string reason = jacobian_->factor(zero_);
  return reason.empty() ? jacobian_->solve(residual_, direction) : reason;
}

std::string Equilibrium::Impl::find_direction_again(double /*tolerance*/, NodeVectors& direction) {
  return matrix->solve(residual_, direction);
}

/// The force that the part λ of the loads leaves unbalanced in a held component [N], beyond the
/// rounding of the forces at work, or what is known to be rounding; nothing where all balance.
std::optional<double> Equilibrium::Impl::unbalanced(double rounding) const {
  const double limit = std::max(kRoundingOfForces * scale_, rounding);
  NodeVectors force = force_ - (1 - lambda_) * first_force_;
  system_->constraints().reduce_force(force);
  for (const Freedom& f : held_)
    if (std::abs(force(f.node, f.component)) > limit) return force(f.node, f.component);
  return std::nullopt;
}

/// What forces did not resist where they were at rest they may resist where loads have stretched
/// them: springs along their length resist being turned. Returns whether less is held now.
bool Equilibrium::Impl::release(const State& state) {
  std::vector<Freedom> now = matrix->hold_rigid_motions(state);
  if (now.size() >= held_.size()) return false;  // as many elsewhere take no load off
  held_ = std::move(now);
  has_released_ = true;
  return true;
}

/// A surface that nothing holds has an equilibrium only if its loads balance.
bool Equilibrium::Impl::accept(State& state, Tangent& kind, double norm, Ending ending) {
  if (ending == Ending::no_step && norm > kRoundingOfForces * scale_) return false;
  // Where Newton's direction leads nowhere, what is left is the forces' rounding: the residual is
  // relative to next to nothing.
  const double rounding = ending == Ending::no_distance ? kOfTheSameKind * norm : 0;
  const std::optional<double> force = unbalanced(rounding);
  if (!force) return true;
  if (release({state.r, NodeVectors::Zero(state.r.rows(), 3), end_})) {
    kind = Tangent::exact;
    (void)evaluate(state, kind, {});
    return false;
  }
  throw Error(ExitCode::diverged,
              fmt::format("{}; a force of {:.3g} N is not balanced", what_is_free(), *force));
}

std::string Equilibrium::Impl::what_is_free() const {
  const std::size_t ways = held_.size();
  if (ways >= 6) return "nothing holds the surface, and its loads do not balance";
  return fmt::format(
      "the surface is free to move as a rigid body in {} {}, and its loads do not "
      "balance",
      ways, ways == 1 ? "way" : "ways");
}

/// K Δr = f0 with what is prescribed on the other side: at first order in it.
std::string Equilibrium::Impl::solve_linear(State& state) {
  lambda_ = 1;
  NodeVectors moved = target_ - start_;
  for (int c = 0; c < 3; ++c)
    for (Index a = 0; a < moved.rows(); ++a)
      if (!system_->constraints().reduction().prescribed(a, c)) moved(a, c) = 0;
  residual_ = first_force_;
  NodeVectors direction;
  std::string reason;
  if (has_potential_) {
    matrix->evaluate(state);
    NodeVectors product;
    matrix->matrix().multiply(moved, product);
    residual_ -= product;
    reason = matrix->factor(zero_);
    if (reason.empty()) reason = matrix->solve(residual_, direction);
  } else if (!moved.isZero(0)) {
    throw InputError("'linear' with moved constraints takes energies and forces with a potential");
  } else {
    Tangent kind = Tangent::exact;
    reason = find_direction(state, 0, kind, direction);
  }
  if (reason.empty()) state.r += direction + moved;
  return reason;
}

Equilibrium::Equilibrium(EquilibriumSettings settings) : impl_(std::make_unique<Impl>(settings)) {}
Equilibrium::~Equilibrium() = default;
void Equilibrium::begin(System& system, const State& from, double end) {
  impl_->begin(system, from, end);
}
bool Equilibrium::has_potential() const { return impl_->has_potential(); }
std::string Equilibrium::solve(double lambda, State& state) { return impl_->solve(lambda, state); }
std::string Equilibrium::solve_linear(State& state) { return impl_->solve_linear(state); }
NewtonMatrix& Equilibrium::matrix() { return *impl_->matrix; }

}  // namespace deform
