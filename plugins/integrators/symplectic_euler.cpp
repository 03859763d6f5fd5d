#include <deform/solve/integrator.h>

namespace {
using namespace deform;

/// v⁺ = v + dt f(r, v)/m with the damping taken at v⁺, then r⁺ = r + dt v⁺: explicit, no matrix.
class SymplecticEuler final : public Integrator {
 public:
  SymplecticEuler(const NoParameters& /*parameters*/, const Setup& /*setup*/) {}

  void advance(System& system, State& state, double step) override {
    system.evaluate(state);
    // What acts on tied components, their inertia too, goes to those that they follow.
    mass_ = system.mass().replicate(1, 3);
    damping_ = system.damping().replicate(1, 3);
    force_ = system.force();
    for (NodeVectors* x : {&mass_, &damping_, &force_}) system.reduce_force(*x);
    before_ = state.r;
    for (int c = 0; c < 3; ++c)
      for (Index a = 0; a < force_.rows(); ++a)
        if (system.reduction().free(a, c))
          state.v(a, c) = (mass_(a, c) * state.v(a, c) + step * force_(a, c)) /
                          (mass_(a, c) + step * damping_(a, c));
    state.r += step * state.v;
    state.time += step;
    system.constrain(before_, step, state);
  }

 private:
  NodeVectors mass_, damping_, force_, before_;
};

}  // namespace

DEFORM_PLUGIN(SymplecticEuler, NoParameters, .name = "symplectic_euler", .version = "1.0",
              .summary = "explicit; stable for steps below 2/ω of the stiffest mode",
              .formula = "v⁺ = (m v + dt f(r))/(m + dt γA), r⁺ = r + dt v⁺",
              .source = "Hairer, Lubich, Wanner, Geometric Numerical Integration, I.1")
