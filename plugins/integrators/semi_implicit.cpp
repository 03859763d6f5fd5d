#include <deform/solve/integrator.h>

namespace {
using namespace deform;

/// The semi-implicit step of Terzopoulos et al. (1987) for (16), with K, c and the loads of the
/// known state:
///   (K + mu/dt² + gamma/(2dt)) r⁺ = f + c + (mu/dt² + gamma/(2dt)) r + (mu/dt − gamma/2) v,
/// v = (r − r⁻)/dt. As the internal force is c − K r, it is solved for the increment r⁺ − r, whose
/// right-hand side is the total force: the same step, less rounding.
class SemiImplicit final : public Integrator {
 public:
  SemiImplicit(const NoParameters& /*parameters*/, const Setup& /*setup*/) {}

  void advance(System& system, State& state, double step) override {
    system.evaluate_with_operator(state);
    // Force fields with a scalar damping tangent take it implicitly: f(v⁺) = f(v) − c (v⁺ − v), v⁺
    // = Δr/dt.
    const NodeValues& c = system.force_damping();
    diagonal_ = system.mass() / (step * step) + system.damping() / (2 * step) + c / step;
    momentum_ = system.mass() / step - system.damping() / 2 + c;
    right_ = system.force();
    for (int i = 0; i < 3; ++i) right_.col(i) += momentum_.cwiseProduct(state.v.col(i));

    target_ = state.r;
    system.prescribe(state.time + step, target_);
    increment_ = target_ - state.r;  // of the prescribed components; the others are solved for
    system.solve(diagonal_, right_, increment_);
    state.r += increment_;
    state.v = increment_ / step;
    state.time += step;
    system.prescribe(state.time, state.r);  // exactly there: adding the increment has rounded
  }

 private:
  NodeValues diagonal_, momentum_;
  NodeVectors right_, target_, increment_;
};

}  // namespace

DEFORM_PLUGIN(SemiImplicit, NoParameters, .name = "semi_implicit", .version = "1.0",
              .summary = "one linear solve a step with the lagged operator",
              .formula = "(K + mu/dt² + gamma/(2dt)) (r⁺ − r) = f(r) + (mu/dt − gamma/2) v",
              .source = "Terzopoulos et al. 1987; Wu & Melo (16)")
