#include <deform/solve/for_system.h>
#include <deform/solve/integrator.h>
#include <deform/solve/lagged_matrix.h>

namespace {
using namespace deform;

struct Parameters {
  double tolerance = 1e-3;
  static void declare(Declaration<Parameters>& d) {
    d("tolerance", &Parameters::tolerance, "1",
      "where the linear solver is iterative: what it may leave of the error that going on with the "
      "old velocity would make")
        .above(0)
        .at_most(0.01);
  }
};

/// The semi-implicit step of Terzopoulos et al. (1987) for (16), with K, c and the loads of the
/// known state (loads of the step's middle):
///   (K + mu/dt² + gamma/(2dt)) r⁺ = f + c + (mu/dt² + gamma/(2dt)) r + (mu/dt − gamma/2) v,
/// v = (r − r⁻)/dt. As the internal force is c − K r, it is solved for the increment r⁺ − r, whose
/// right-hand side is the total force: the same step, less rounding.
class SemiImplicit final : public Integrator {
 public:
  SemiImplicit(const Parameters& p, const Setup& /*setup*/) : tolerance_(p.tolerance) {}

  [[nodiscard]] bool lags_coefficients() const override { return true; }
  void advance(System& system, State& state, double step) override {
    // Loads of the step's middle: their mean where they change linearly from break to break.
    const double begin = state.time;
    state.time += step / 2;
    matrix_(system).evaluate(state, right_);
    state.time = begin;
    // Force fields with a scalar damping tangent take it implicitly: f(v⁺) = f(v) − c (v⁺ − v), v⁺
    // = Δr/dt.
    const NodeValues& c = matrix_(system).force_damping();
    diagonal_ = system.mass() / (step * step) + system.damping() / (2 * step) + c / step;
    momentum_ = system.mass() / step - system.damping() / 2 + c;
    for (int i = 0; i < 3; ++i) right_.col(i) += momentum_.cwiseProduct(state.v.col(i));

    target_ = state.r + step * state.v;
    system.constraints().prescribe(state.time + step, target_);
    increment_ = target_ - state.r;  // of the prescribed components; of the others a guess
    matrix_(system).solve(diagonal_, right_, increment_, tolerance_);
    state.r += increment_;
    state.v = increment_ / step;
    state.time += step;
    system.constraints().prescribe(state.time,
                                   state.r);  // exactly there: adding the increment has rounded
  }

 private:
  double tolerance_;
  ForSystem<LaggedMatrix> matrix_;
  NodeValues diagonal_, momentum_;
  NodeVectors right_, target_, increment_;
};

}  // namespace

DEFORM_PLUGIN(SemiImplicit, Parameters, .name = "semi_implicit", .version = "1.0",
              .summary = "one linear solve a step with the lagged operator",
              .formula = "(K + mu/dt² + gamma/(2dt)) (r⁺ − r) = f(r) + (mu/dt − gamma/2) v",
              .source = "Terzopoulos et al. 1987; Wu & Melo (16)")
