/// What the implicit integrators have in common.
#pragma once

#include <deform/solve/implicit_stage.h>
#include <deform/solve/stepped_integrator.h>

namespace deform {

struct ImplicitParameters : StepControl {
  double tolerance = StageSettings{}.tolerance;
  std::int64_t iterations = StageSettings{}.iterations;
  double newton_error = StageSettings{}.newton_error;

  template <class Parameters>
  static void declare(Declaration<Parameters>& d) {
    StepControl::declare(d);
    d("tolerance", &ImplicitParameters::tolerance, "1",
      "of the residual force, relative to the forces at work")
        .above(0);
    d("iterations", &ImplicitParameters::iterations, "",
      "of Newton's method in a step, at most; then half the step is tried")
        .at_least(1);
    d("newton_error", &ImplicitParameters::newton_error, "1",
      "of a step, that Newton's method may leave: root mean square over the mass, in sizes of the "
      "surface, estimated from its corrections; 0: `tolerance` alone decides. 1e-4 takes two or "
      "three "
      "a step where motion is resolved")
        .at_least(0)
        .at_most(0.1);
  }
  [[nodiscard]] StageSettings settings() const { return {tolerance, iterations, newton_error}; }
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
    stage_.end = from.time + h;
    stage_.time = from.time + h / 2;
    stage_.by_strains = true;
    stage_.s = 0;
  }

  ImplicitStage newton_;
  Stage stage_;  // of the last attempt: kept for its memory
};

}  // namespace deform
