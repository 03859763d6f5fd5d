/// What the implicit integrators have in common.
#pragma once

#include <cmath>
#include <limits>

#include <deform/solve/implicit_stage.h>
#include <deform/solve/stepped_integrator.h>

namespace deform {

struct ImplicitParameters : StepControl {
  static constexpr double kNotGiven = std::numeric_limits<double>::quiet_NaN();
  /// Part of a step's own error that Newton's method leaves unless the scene says otherwise.
  static constexpr double kShare = 0.1;

  double tolerance = kNotGiven;
  std::int64_t iterations = StageSettings{}.iterations;
  double newton_error = kNotGiven;

  template <class Parameters>
  static void declare(Declaration<Parameters>& d) {
    StepControl::declare(d);
    d("tolerance", &ImplicitParameters::tolerance, "1",
      "of the residual force, relative to the forces at work; 1e-6 when absent, and where "
      "`newton_error` is absent, too, Newton's method ends before where it leaves less than a "
      "tenth of the step's own error")
        .above(0)
        .optional();
    d("iterations", &ImplicitParameters::iterations, "",
      "of Newton's method in a step, at most; then half the step is tried")
        .at_least(1);
    d("newton_error", &ImplicitParameters::newton_error, "1",
      "of a step, that Newton's method may leave: root mean square over the mass, in "
      "characteristic lengths, estimated from its corrections; 0: `tolerance` alone decides; when "
      "absent a tenth of the step's own error where no `tolerance` is given, else 0")
        .at_least(0)
        .at_most(0.1)
        .optional();
  }
  [[nodiscard]] StageSettings settings() const {
    const bool has_tolerance = !std::isnan(tolerance), has_error = !std::isnan(newton_error);
    return {.tolerance = has_tolerance ? tolerance : StageSettings{}.tolerance,
            .iterations = iterations,
            .newton_error = has_error ? newton_error : 0,
            .newton_share = has_tolerance || has_error ? 0 : kShare};
  }
};

/// An integrator whose step is one stage.
class ImplicitIntegrator : public SteppedIntegrator {
 public:
  explicit ImplicitIntegrator(const ImplicitParameters& p)
      : SteppedIntegrator(p), newton_(p.settings()) {}

  /// Contact goes on where loads jump; what a method remembers of earlier steps does not.
  void restart() override { forget_history(); }
  [[nodiscard]] Solves solves() const override { return Solves::tangents; }
  void save(Memory& memory) const override {
    SteppedIntegrator::save(memory);
    newton_.save(memory);
  }
  void load(const Memory& memory) override {
    SteppedIntegrator::load(memory);
    newton_.load(memory);
  }

 protected:
  void forget() override {
    newton_.forget();
    forget_history();
  }
  /// Of earlier steps.
  virtual void forget_history() {}

  /// The stage of a step of backward Euler; other methods then change what differs. Loads are
  /// those of the step's middle: over a step, from one break to the next at most, that is their
  /// mean where they change linearly, so that their impulse is the right one.
  void begin_stage(const State& from, double h) {
    stage_.r_base = stage_.start = from.r;
    stage_.v_base = from.v;
    stage_.tau = h;
    stage_.begin = from.time;
    stage_.end = from.time + h;
    stage_.time = from.time + h / 2;
    stage_.by_strains = true;
    stage_.s = 0;
    stage_.error_per_change = 0;
  }

  ImplicitStage newton_;
  Stage stage_;  // of the last attempt: kept for its memory
};

}  // namespace deform
