#include "implicit.h"

namespace {
using namespace deform;

struct Parameters : ImplicitParameters {
  static void declare(Declaration<Parameters>& d) { ImplicitParameters::declare(d); }
};

/// r⁺ = r + h v⁺, M (v⁺ − v)/h = f(r⁺, v⁺, t⁺) − Γ v⁺: first order, damps what it does not resolve.
class BackwardEuler final : public ImplicitIntegrator {
 public:
  BackwardEuler(const Parameters& p, const Setup& /*setup*/) : ImplicitIntegrator(p) {}

 protected:
  [[nodiscard]] Attempt attempt(System& system, const State& from, double h, State& to) override {
    const double end = from.time + h;
    const Stage stage{.r_base = from.r,
                      .v_base = from.v,
                      .tau = h,
                      .time = just_before(end, h),
                      .start = from.r,
                      .end = end,
                      .by_strains = true};
    to.r = from.r + h * from.v;
    system.prescribe(end, to.r);
    std::string failure = newton_.solve(system, stage, to);
    to.time = end;
    // r(t + h) = r + h v⁺ − h² r̈/2 + …, with r̈ = (v⁺ − v)/h.
    return {std::move(failure), h / 2 * (to.v - from.v), newton_.resolves_contacts()};
  }
  [[nodiscard]] int local_order() const override { return 2; }
};

}  // namespace

DEFORM_PLUGIN(BackwardEuler, Parameters, .name = "backward_euler", .version = "1.0",
              .summary =
                  "implicit, first order, for steps of any size: minimises the incremental "
                  "potential by Newton's method with line search",
              .formula = "M (v⁺ − v)/h = f(r⁺, v⁺) − Γ v⁺, r⁺ = r + h v⁺",
              .source =
                  "Hairer & Wanner, Solving Ordinary Differential Equations II, IV.3; "
                  "incremental potential: Radovitzky & Ortiz 1999")
