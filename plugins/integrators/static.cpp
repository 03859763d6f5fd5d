#include <algorithm>
#include <cstdio>
#include <optional>
#include <string>

#include <deform/log.h>
#include <deform/solve/equilibrium.h>
#include <deform/solve/integrator.h>
#include <deform/solve/relaxation.h>

namespace {
using namespace deform;

struct Parameters {
  double tolerance = 1e-9;
  std::int64_t iterations = 50;
  std::int64_t load_steps = 1;
  bool linear = false;
  static void declare(Declaration<Parameters>& d) {
    d("tolerance", &Parameters::tolerance, "1",
      "of the residual force, relative to the forces at work")
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

/// Equilibrium f(r) = 0 at the end of each step, by Newton's method. A step's load grows from
/// nothing to all, by parts that are halved where it fails (Equilibrium). With colliders it goes by
/// pseudo-steps (Relaxation).
class Static final : public Integrator {
 public:
  Static(const Parameters& p, const Setup& /*setup*/)
      : parameters_(p),
        equilibrium_({.tolerance = p.tolerance, .iterations = p.iterations}),
        relaxation_({.tolerance = p.tolerance, .iterations = p.iterations}) {}

  [[nodiscard]] bool is_static() const override { return true; }
  /// Contact is not linear.
  [[nodiscard]] bool resolves_contacts() const override { return !parameters_.linear; }
  [[nodiscard]] Solves solves() const override { return Solves::tangents; }
  void save(Memory& memory) const override { relaxation_.save(memory); }
  void load(const Memory& memory) override { relaxation_.load(memory); }

  void advance(System& system, State& state, double step) override {
    end_ = state.time + step;
    if (system.contact().bodies() > 0) return relax(system, state);
    equilibrium_.begin(system, state, end_);
    if (!equilibrium_.has_potential() && !parameters_.linear)
      say_once_what_has_no_potential(system.evaluator());
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
  /// With colliders.
  void relax(System& system, State& state) {
    const std::string reason = relaxation_.solve(system, end_, state);
    if (!reason.empty()) throw Error(ExitCode::diverged, "no equilibrium in contact: " + reason);
  }

  /// Load step by load step to the end of the step, halving those that lead nowhere.
  void load_up(System& system, State& state) {
    const double first = 1 / static_cast<double>(parameters_.load_steps);
    double done = 0, part = first;
    int halvings = 0;
    system.step_report().substeps = 0;
    while (done < 1) {
      const double next = done + part > 1 - 1e-9 ? 1 : done + part;
      State trial = state;
      const std::string reason = equilibrium_.solve(next, trial);
      ++system.step_report().substeps;
      if (reason.empty()) {
        state = trial;
        done = next;
        part = std::min(2 * part, first);
        continue;
      }
      if (++halvings > kMostHalvings) give_up(state, done, reason);
      log::debug("static: " + reason + "; half the load step");
      part /= 2;
    }
  }

  void say_once_what_has_no_potential(const Evaluator& evaluator) {
    if (said_) return;
    said_ = true;
    std::string names;
    for (const auto& list : {evaluator.without_potential(), evaluator.without_tangent()})
      for (const std::string& name : list)
        if (names.find(name) == std::string::npos) names += (names.empty() ? "" : ", ") + name;
    log::info("static: no potential and tangent of " + names +
              ": Newton's method goes by differences of the force");
  }

  void solve_linear(System& system, State& state) {
    const std::string reason = equilibrium_.solve_linear(state);
    if (!reason.empty())
      throw Error(ExitCode::diverged,
                  "linear statics has no solution: the tangent at the beginning is not positive "
                  "definite, or singular (" +
                      reason + ")");
    system.step_report().iterations = 1;
  }

  /// Eigenvalues at the last tangent; nothing where they cannot be had: an equilibrium, or the
  /// reason why there is none, is worth reporting without.
  [[nodiscard]] std::optional<NewtonMatrix::Stability> stability() {
    try {
      return equilibrium_.matrix().stability();
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
  void report_stability(const System& system, const State& state) {
    if (!system.evaluator().without_tangent().empty()) return;
    NewtonMatrix& tangent = equilibrium_.matrix();
    tangent.evaluate(state);
    const bool has_potential = equilibrium_.has_potential();
    if (has_potential && tangent.factor(NodeValues::Zero(system.rows())).empty()) return;
    const std::optional<NewtonMatrix::Stability> found = stability();
    if (!found || found->negative == 0) return;
    const std::string eigenvalues =
        std::to_string(found->negative) +
        (found->negative == 1 ? " negative eigenvalue" : " negative eigenvalues");
    const std::string where = "static: the equilibrium at " + std::to_string(end_) + " s ";
    const std::string lowest = ", lowest " + scientific(found->lowest) + " /s²)";
    if (has_potential)
      log::warn(where + "is not stable: a limit or bifurcation point was passed (" + eigenvalues +
                " of the tangent" + lowest);
    else
      log::warn(
          where +
          "is most likely not stable: there are displacements along which the forces do work (" +
          eigenvalues + " of the tangent's symmetric part" + lowest);
  }

  [[noreturn]] void give_up(const State& state, double done, const std::string& reason) {
    std::string why =
        "no equilibrium beyond " + std::to_string(100 * done) + " % of the step's load: " + reason;
    if (equilibrium_.has_potential()) {
      equilibrium_.matrix().evaluate(state);
      if (const std::optional<NewtonMatrix::Stability> found = stability())
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
  Equilibrium equilibrium_;
  Relaxation relaxation_;
  bool said_ = false;
  double end_ = 0;
};

}  // namespace

DEFORM_PLUGIN(Static, Parameters, .name = "static", .version = "1.0",
              .summary = "equilibrium at each step's end: Newton's method, line search, load steps",
              .formula = "f(r) = 0; K Δr = f(r), K = ∂²Π/∂r²",
              .source = "Nocedal & Wright, Numerical Optimization, chapters 3 and 6")
