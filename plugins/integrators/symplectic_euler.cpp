#include <deform/solve/integrator.h>

namespace {
using namespace deform;

/// v⁺ = v + dt f(r, v)/m with the damping taken at v⁺, then r⁺ = r + dt v⁺: explicit, and no matrix
/// but that of masses where ties make one of them: TᵀMT v̇ = Tᵀ(f − Γ v) then, damping at v.
class SymplecticEuler final : public Integrator {
 public:
  SymplecticEuler(const NoParameters& /*parameters*/, const Setup& /*setup*/) {}

  [[nodiscard]] Solves solves() const override { return Solves::nothing; }

  void advance(System& system, State& state, double step) override {
    // Loads of the step's middle: their mean where they change linearly from break to break.
    const double begin = state.time;
    state.time += step / 2;
    system.evaluator().force(state, force_);
    state.time = begin;
    before_ = state.r;
    if (system.constraints().reduction().ties().empty()) {
      push_nodes(system, state, step);
    } else {
      force_ -= system.damping().asDiagonal() * state.v;
      system.mass_matrix().accelerate(force_, acceleration_);
      state.v += step * acceleration_;
    }
    state.r += step * state.v;
    state.time += step;
    system.constraints().constrain(before_, step, state);
  }

 private:
  void push_nodes(const System& system, State& state, double step) const {
    const NodeValues& m = system.mass();
    const NodeValues& damping = system.damping();
    for (int c = 0; c < 3; ++c)
      for (Index a = 0; a < m.size(); ++a)
        if (system.constraints().reduction().free(a, c))
          state.v(a, c) = (m[a] * state.v(a, c) + step * force_(a, c)) / (m[a] + step * damping[a]);
  }

  NodeVectors force_, acceleration_, before_;
};

}  // namespace

DEFORM_PLUGIN(SymplecticEuler, NoParameters, .name = "symplectic_euler", .version = "1.0",
              .summary = "explicit; stable for steps below 2/ω of the stiffest mode",
              .formula = "v⁺ = (m v + dt f(r))/(m + dt γA), r⁺ = r + dt v⁺",
              .source = "Hairer, Lubich, Wanner, Geometric Numerical Integration, I.1")
