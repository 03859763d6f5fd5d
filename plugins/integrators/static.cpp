#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>
#include <string>

#include <deform/geometry/characteristic_length.h>
#include <deform/geometry/rounding.h>
#include <deform/log.h>
#include <deform/solve/integrator.h>

namespace {
using namespace deform;

struct Parameters {
  double tolerance = 1e-9;
  std::int64_t iterations = 50;
  std::int64_t load_steps = 1;
  bool linear = false;
  static void declare(Declaration<Parameters>& d) {
    d("tolerance", &Parameters::tolerance, "1",
      "of the force that is left over, relative to the forces at work")
        .above(0);
    d("iterations", &Parameters::iterations, "", "of Newton's method in a load step, at most")
        .at_least(1);
    d("load_steps", &Parameters::load_steps, "",
      "parts that a step's load is applied in at first; halved where Newton's method fails")
        .at_least(1);
    d("linear", &Parameters::linear, "",
      "linear statics: one step with the exact tangent of the state at the step's beginning");
  }
};

/// A load step is halved this often before the state is given up.
constexpr int kMostHalvings = 10;
/// A line search halves its step this often.
constexpr int kMostCuts = 24;
/// Whole Newton steps before a line search is tried.
constexpr int kMostLongSteps = 25;
/// Forces that cancel to this part of what they are made of count as balanced where no step helps;
/// a Newton step below this part of the size, or the rounding of positions, moves nothing.
constexpr double kRoundingOfForces = 1e-6, kRoundingOfPositions = 1e-13;
/// Forces that differ by less than this factor are of one kind.
constexpr double kOfTheSameKind = 100;
/// Of the residual at a load step's start: what a residual can be measured by at least.
constexpr double kOfTheStart = 1e-3;

/// What Newton's method ends with.
struct Outcome {
  bool converged = false;
  std::string reason;
};

/// Equilibrium f(r) = 0 at the end of each step, by Newton's method with line search. A step's load
/// grows from nothing to all: with f0 the force at its beginning, f(r) = (1 − λ) f0 is solved for λ
/// from 0 to 1, prescribed components moving along. Where all has a potential Π, what decreases is
/// Π + (1 − λ) f0·r, whose stationary points these are, and the tangent is the exact one, or the
/// projected one where that is indefinite; else it is |f − (1 − λ) f0|, with the derivative of the
/// force by differences.
class Static final : public Integrator {
 public:
  Static(const Parameters& p, const Setup& /*setup*/) : parameters_(p) {}

  [[nodiscard]] bool is_static() const override { return true; }
  [[nodiscard]] Solves solves() const override { return Solves::tangents; }

  void advance(System& system, State& state, double step) override {
    begin(system, state, step);
    if (parameters_.linear) {
      solve_linear(system, state);
    } else {
      load_up(system, state);
      report_stability(system, state);
    }
    state.v.setZero();
    state.time = end_;
  }

 private:
  /// How an equilibrium is looked for.
  enum class Steps {
    newton,  ///< Newton's, whole, with the stress that the last one foresaw in their tangent
    descent  ///< along Newton's or a projected direction, as far as the merit falls
  };

  /// Load step by load step to the end of the step, halving those that lead nowhere.
  void load_up(System& system, State& state) {
    const double first = 1 / static_cast<double>(parameters_.load_steps);
    double done = 0, part = first;
    int halvings = 0;
    system.step_report().substeps = 0;
    while (done < 1) {
      const double next = done + part > 1 - 1e-9 ? 1 : done + part;
      State trial = state;
      Outcome outcome = iterate(system, trial, next, Steps::newton);
      if (!outcome.converged) {
        trial = state;
        outcome = iterate(system, trial, next, Steps::descent);
      }
      ++system.step_report().substeps;
      if (outcome.converged) {
        state = trial;
        done = next;
        part = std::min(2 * part, first);
        continue;
      }
      if (++halvings > kMostHalvings) give_up(system, state, done, outcome.reason);
      log::debug("static: " + outcome.reason + "; half the load step");
      part /= 2;
    }
  }

  void begin(System& system, const State& state, double step) {
    has_potential_ = system.without_potential().empty() && system.without_tangent().empty();
    if (!has_potential_ && !parameters_.linear) say_once_what_has_no_potential(system);
    zero_ = NodeValues::Zero(system.nodes());
    end_ = state.time + step;
    start_ = state.r;
    target_ = state.r;
    system.prescribe(end_, target_);
    State loaded = state;
    loaded.time = end_;
    system.evaluate(loaded);
    first_force_ = system.force();
    held_ = system.hold_rigid_motions(state.r);  // by the forces of the time just evaluated
    start_residual_ = 0;
    size_ = characteristic_length(start_);
    still_ = kRoundingOfPositions * size_ +
             std::max(rounding_of_positions(start_), rounding_of_positions(target_));
  }

  void say_once_what_has_no_potential(const System& system) {
    if (said_) return;
    said_ = true;
    std::string names;
    for (const auto& list : {system.without_potential(), system.without_tangent()})
      for (const std::string& name : list)
        if (names.find(name) == std::string::npos) names += (names.empty() ? "" : ", ") + name;
    log::info("static: no potential and tangent of " + names +
              ": Newton's method goes by differences of the force");
  }

  /// Prescribed components where they are at a part of the load, what is tied behind them.
  void place_prescribed(const System& system, State& state, double lambda) const {
    for (int c = 0; c < 3; ++c)
      for (Index a = 0; a < start_.rows(); ++a)
        if (system.reduction().prescribed(a, c))
          state.r(a, c) = start_(a, c) + lambda * (target_(a, c) - start_(a, c));
    system.follow_ties(state.r);
  }

  [[nodiscard]] double merit(System& system, const State& state, double lambda) {
    if (has_potential_)
      return system.potential(state) + (1 - lambda) * first_force_.cwiseProduct(state.r).sum();
    system.evaluate(state);
    return residual_norm(system, lambda);
  }

  /// Tᵀ(f − (1 − λ) f0) of the last evaluation, without what is held. The forces at work are the
  /// load and, at the same state, what constraints must hold against; where both vanish (a surface
  /// carried elsewhere), a part of what there was before the first step.
  [[nodiscard]] double residual_norm(const System& system, double lambda) {
    residual_ = system.force() - (1 - lambda) * first_force_;
    scale_ = std::max({first_force_.norm(), residual_.norm(), kOfTheStart * start_residual_});
    system.reduce_force(residual_);
    for (const Freedom& f : held_) residual_(f.node, f.component) = 0;
    return residual_.norm();
  }

  /// Newton's direction by the tangent of the last evaluation, or by differences where there is
  /// none; "" or why there is none.
  [[nodiscard]] std::string newton_direction(System& system, const State& state) {
    if (!has_potential_) system.evaluate_with_jacobian(state);
    std::string reason =
        has_potential_ ? system.factor_tangent(zero_) : system.factor_jacobian(zero_);
    if (!reason.empty()) return reason;
    return has_potential_ ? system.solve_tangent(residual_, direction_)
                          : system.solve_jacobian(residual_, direction_);
  }

  /// A direction in which the potential falls, though its Hessian is indefinite; "" or why there is
  /// none.
  [[nodiscard]] std::string projected_direction(System& system, const State& state) {
    system.evaluate_with_tangent(state, Tangent::projected);
    const std::string reason = factor_with_shift(system);
    return reason.empty() ? system.solve_tangent(residual_, direction_) : reason;
  }

  /// The projected tangent may be singular (a flat sheet without tension does not resist bending
  /// in it): the least multiple of the mean stiffness that cures it is added.
  [[nodiscard]] std::string factor_with_shift(System& system) const {
    const double mean = system.mean_stiffness().mean();
    std::string reason = system.factor_tangent(zero_);
    for (double shift = 1e-10; !reason.empty() && shift < 1e-1; shift *= 10)
      reason = system.factor_tangent(NodeValues::Constant(system.nodes(), shift * mean));
    return reason;
  }

  [[nodiscard]] Outcome iterate(System& system, State& state, double lambda, Steps steps) {
    const std::int64_t most = steps == Steps::newton
                                  ? std::min<std::int64_t>(kMostLongSteps, parameters_.iterations)
                                  : parameters_.iterations;
    state.time = end_;
    if (has_released_) held_ = system.hold_rigid_motions(state.r), has_released_ = false;
    place_prescribed(system, state, lambda);
    system.step_report().residuals.clear();
    NodeVectors before;
    double moved = kInfinity;  // by the last step [m]
    // What is an equilibrium with the components held so far; nothing where less is held from now
    // on, and the search goes on.
    const auto ends = [&](double rounding) -> std::optional<Outcome> {
      if (!release(system, state, lambda, rounding)) return accept(system, lambda, rounding);
      before.resize(0, 3), moved = kInfinity;
      return std::nullopt;
    };
    for (std::int64_t i = 0;; ++i) {
      evaluate(system, state, steps, before);
      const double norm = residual_norm(system, lambda);
      if (i == 0) start_residual_ = norm;
      const double relative = report(system, norm, i);
      const bool is_still = moved <= still_;
      if (relative <= parameters_.tolerance || (is_still && relative <= kRoundingOfForces)) {
        if (const auto outcome = ends(0)) return *outcome;
        continue;
      }
      if (i >= most || !std::isfinite(norm))
        return {false,
                std::to_string(i) + " iterations leave a residual of " + scientific(relative)};
      ++system.step_report().iterations;

      std::string reason = newton_direction(system, state);
      const double longest = reason.empty() ? direction_.rowwise().norm().maxCoeff() : 0;
      // What is left over is the forces' rounding: the residual is relative to next to nothing.
      if (reason.empty() && longest <= still_) {
        if (const auto outcome = ends(kOfTheSameKind * norm)) return *outcome;
        continue;
      }
      if (steps == Steps::newton) {
        if (reason.empty() && !(longest <= 2 * size_)) reason = "it leads out of all bounds";
        if (!reason.empty()) return {false, "no Newton step (" + reason + ")"};
        before = state.r;
        state.r += direction_;
        moved = longest;
        continue;
      }
      if (!reason.empty() && has_potential_) reason = projected_direction(system, state);
      if (!reason.empty()) return {false, "no direction of descent (" + reason + ")"};
      moved = search(system, state, lambda, norm);
      if (moved > 0) continue;
      system.evaluate(state);  // the search has left the forces of another state
      if (relative <= kRoundingOfForces) {
        if (const auto outcome = ends(0)) return *outcome;
        continue;
      }
      return {false, "no step along the direction found comes closer to equilibrium"};
    }
  }

  /// `before`: positions before the last whole step; empty where there was none.
  void evaluate(System& system, const State& state, Steps steps, const NodeVectors& before) const {
    if (!has_potential_) {
      system.evaluate(state);
    } else if (steps == Steps::newton && before.size() > 0) {
      system.evaluate_with_tangent(state, Tangent::foreseen, &before);
    } else {
      system.evaluate_with_tangent(state, Tangent::exact);
    }
  }

  /// The residual relative to the forces at work, also in the report and the log.
  [[nodiscard]] double report(System& system, double norm, std::int64_t iteration) const {
    StepReport& report = system.step_report();
    report.residual = scale_ > 0 ? norm / scale_ : 0;
    report.residuals.push_back(report.residual);
    log::debug("static: iteration " + std::to_string(iteration) + ", residual " +
               scientific(report.residual));
    return report.residual;
  }

  /// The force that the part λ of the loads leaves over in a held component [N], beyond the
  /// rounding of the forces at work, or what is known to be rounding; nothing where all balance.
  [[nodiscard]] std::optional<double> left_over(const System& system, double lambda,
                                                double rounding = 0) const {
    const double limit = std::max(kRoundingOfForces * scale_, rounding);
    NodeVectors left = system.force() - (1 - lambda) * first_force_;
    system.reduce_force(left);
    for (const Freedom& f : held_)
      if (std::abs(left(f.node, f.component)) > limit) return left(f.node, f.component);
    return std::nullopt;
  }

  /// What forces did not resist where they were at rest they may resist where loads have stretched
  /// them: springs along their length resist being turned. Returns whether less is held now.
  [[nodiscard]] bool release(System& system, const State& state, double lambda, double rounding) {
    if (!left_over(system, lambda, rounding)) return false;
    const std::size_t before = held_.size();
    held_ = system.hold_rigid_motions(state.r);
    has_released_ = true;
    return held_.size() < before;
  }

  /// A surface that nothing holds has an equilibrium only if its loads balance.
  [[nodiscard]] Outcome accept(const System& system, double lambda, double rounding = 0) const {
    if (const std::optional<double> force = left_over(system, lambda, rounding))
      throw Error(ExitCode::diverged,
                  what_is_free() + "; a force of " + scientific(*force) + " N is left over");
    return {true, ""};
  }

  [[nodiscard]] std::string what_is_free() const {
    const std::string count = std::to_string(held_.size());
    if (held_.size() >= 6) return "nothing holds the surface, and its loads do not balance";
    return "the surface is free to move as a rigid body in " + count +
           (held_.size() == 1 ? " way" : " ways") + ", and its loads do not balance";
  }

  /// Goes along the direction as far as it helps; returns how far the farthest node moved [m].
  [[nodiscard]] double search(System& system, State& state, double lambda, double norm) {
    const double before = has_potential_ ? merit(system, state, lambda) : norm;
    const double slope = has_potential_ ? -residual_.cwiseProduct(direction_).sum() : -norm;
    const double rounding = 1e-14 * std::abs(before);
    const double longest = direction_.rowwise().norm().maxCoeff();
    double s = std::min(1.0, size_ / std::max(longest, 1e-300));
    State trial = state;
    for (int cut = 0; cut < kMostCuts; ++cut, s /= 2) {
      trial.r = state.r + s * direction_;
      const double there = merit(system, trial, lambda);
      if (std::isfinite(there) && there <= before + 1e-4 * s * slope + rounding) {
        state.r = trial.r;
        return s * longest;
      }
    }
    // Close to the end the potential changes by less than its rounding: the residual goes on.
    trial.r = state.r + direction_;
    system.evaluate(trial);
    if (!(residual_norm(system, lambda) < 0.5 * norm)) return 0;
    state.r = trial.r;
    return longest;
  }

  /// K Δr = f0 with what moves as it is told on the other side: at first order in it.
  void solve_linear(System& system, State& state) {
    NodeVectors moved = target_ - start_;
    for (int c = 0; c < 3; ++c)
      for (Index a = 0; a < moved.rows(); ++a)
        if (!system.reduction().prescribed(a, c)) moved(a, c) = 0;
    residual_ = first_force_;
    if (has_potential_) {
      system.evaluate_with_tangent(state, Tangent::exact);
      NodeVectors product;
      system.tangent().multiply(moved, product);
      residual_ -= product;
    } else if (!moved.isZero(0)) {
      throw InputError(
          "'linear' with moved constraints takes energies and forces with a potential");
    }
    const std::string reason = newton_direction(system, state);
    if (!reason.empty())
      throw Error(ExitCode::diverged,
                  "linear statics has no solution: the tangent at the beginning is not positive "
                  "definite, or singular (" +
                      reason + ")");
    state.r += direction_ + moved;
    system.step_report().iterations = 1;
  }

  /// Eigenvalues at the last tangent; nothing where they cannot be had: an equilibrium, or the
  /// reason why there is none, is worth reporting without.
  [[nodiscard]] static std::optional<System::Stability> stability_of(System& system) {
    try {
      return system.stability();
    } catch (const Error& e) {
      if (e.code() != ExitCode::diverged) throw;
      return std::nullopt;
    }
  }

  /// Whether the equilibrium is one that the surface stays at. Where all has a potential, negative
  /// eigenvalues of the tangent say that it is not. Where loads follow the surface, the tangent is
  /// the symmetric part of the forces' derivative: if that is positive definite, the forces resist
  /// every displacement; if it is not, there are displacements along which they do work. The
  /// surface then mostly leaves, though the unsymmetric part might hold it; and flutter is known in
  /// neither case. Where something has no tangent, nothing is known.
  void report_stability(System& system, const State& state) {
    if (!system.without_tangent().empty()) return;
    system.evaluate_with_tangent(state, Tangent::exact);
    if (has_potential_ && system.factor_tangent(zero_).empty()) return;
    const std::optional<System::Stability> found = stability_of(system);
    if (!found || found->negative == 0) return;
    const std::string eigenvalues =
        std::to_string(found->negative) +
        (found->negative == 1 ? " negative eigenvalue" : " negative eigenvalues");
    const std::string where = "static: the equilibrium at " + std::to_string(end_) + " s ";
    const std::string lowest = ", lowest " + scientific(found->lowest) + " /s²)";
    if (has_potential_)
      log::warn(where + "is not stable: a limit or bifurcation point was passed (" + eigenvalues +
                " of the tangent" + lowest);
    else
      log::warn(
          where +
          "is most likely not stable: there are displacements along which the forces do work (" +
          eigenvalues + " of the tangent's symmetric part" + lowest);
  }

  [[noreturn]] void give_up(System& system, const State& state, double done,
                            const std::string& reason) {
    std::string why =
        "no equilibrium beyond " + std::to_string(100 * done) + " % of the step's load: " + reason;
    if (has_potential_) {
      system.evaluate_with_tangent(state, Tangent::exact);
      if (const std::optional<System::Stability> found = stability_of(system))
        why += "; the lowest eigenvalue of the tangent there is " + scientific(found->lowest) +
               " /s² (near 0: a limit or bifurcation point)";
    }
    throw Error(ExitCode::diverged, why);
  }

  static std::string scientific(double value) {
    char text[32];
    std::snprintf(text, sizeof text, "%.3g", value);
    return text;
  }

  Parameters parameters_;
  bool has_potential_ = true, said_ = false;
  bool has_released_ = false;  // the last search for an equilibrium ended with other held_
  double end_ = 0, size_ = 0, scale_ = 0, start_residual_ = 0;
  double still_ = 0;  // Newton steps that are not longer move nothing [m]
  std::vector<Freedom> held_;
  NodeValues zero_;
  NodeVectors start_, target_, first_force_, residual_, direction_;
};

}  // namespace

DEFORM_PLUGIN(Static, Parameters, .name = "static", .version = "1.0",
              .summary = "equilibrium at each step's end: Newton's method, line search, load steps",
              .formula = "f(r) = 0; K Δr = f(r), K = ∂²Π/∂r²",
              .source = "Nocedal & Wright, Numerical Optimization, chapters 3 and 6")
