#include <deform/solve/integrator.h>

namespace {
using namespace deform;

/// v⁺ = v + dt f(r, v)/m with the damping taken at v⁺, then r⁺ = r + dt v⁺: explicit, no matrix.
class SymplecticEuler final : public Integrator {
 public:
  SymplecticEuler(const NoParameters& /*parameters*/, const Setup& /*setup*/) {}

  void advance(System& system, State& state, double step) override {
    system.evaluate(state);
    const NodeValues& mass = system.mass();
    inverse_ = (mass + step * system.damping()).cwiseInverse();
    before_ = state.r;
    for (int c = 0; c < 3; ++c) {
      auto v = state.v.col(c);
      v = (mass.cwiseProduct(v) + step * system.force().col(c)).cwiseProduct(inverse_);
    }
    state.r += step * state.v;
    state.time += step;
    system.constrain(before_, step, state);
  }

 private:
  NodeValues inverse_;
  NodeVectors before_;
};

}  // namespace

DEFORM_PLUGIN(SymplecticEuler, NoParameters, .name = "symplectic_euler", .version = "1.0",
              .summary = "explicit; stable for steps below 2/ω of the stiffest mode",
              .formula = "v⁺ = (m v + dt f(r))/(m + dt γA), r⁺ = r + dt v⁺",
              .source = "Hairer, Lubich, Wanner, Geometric Numerical Integration, I.1")
