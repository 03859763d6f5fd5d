#include "implicit.h"
#include "second_order_error.h"

namespace {
using namespace deform;

struct Parameters : ImplicitParameters {
  static void declare(Declaration<Parameters>& d) { ImplicitParameters::declare(d); }
};

/// r⁺ = r + h v⁺, M (v⁺ − v)/h = f(r⁺, v⁺, t + h/2) − Γ v⁺: first order, damps what it does not
/// resolve.
class BackwardEuler final : public ImplicitIntegrator {
 public:
  BackwardEuler(const Parameters& p, const Setup& /*setup*/) : ImplicitIntegrator(p) {}

  void save(Memory& memory) const override {
    ImplicitIntegrator::save(memory);
    if (newton_.counts_corrections()) last_.save(memory);
  }
  void load(const Memory& memory) override {
    ImplicitIntegrator::load(memory);
    if (newton_.counts_corrections()) last_.load(memory);
  }

 protected:
  [[nodiscard]] Attempt attempt(System& system, const State& from, double h, State& to) override {
    const double end = from.time + h;
    begin_stage(from, h);
    // The step is wrong by − h² r̈/2, and differs from this by h² r̈.
    stage_.prediction = from.r + h * from.v;
    stage_.error_per_change = 0.5;
    // v⁺ = v + h a, a being about that of the last step.
    last_.extrapolate(from, h, 1.0, to.r);
    system.constraints().prescribe(end, to.r);
    std::string failure = newton_.solve(system, stage_, to);
    to.time = end;
    if (!failure.empty()) return {std::move(failure), {}, false};
    std::vector<ContactImpulse> contact = newton_.settle(system, stage_, from, h, to);
    // r(t + h) = r + h v⁺ − h² r̈/2 + …, with r̈ = (v⁺ − v)/h.
    return {"", with_error() ? NodeVectors(h / 2 * (to.v - from.v)) : NodeVectors(),
            newton_.resolves_contacts(), std::move(contact)};
  }
  [[nodiscard]] int local_order() const override { return 2; }
  [[nodiscard]] bool is_of_first_order() const override { return true; }

  void accept(const State& from, const State& to) override {
    if (newton_.counts_corrections()) last_.accept(from, to);
  }
  void forget_history() override { last_.forget(); }

 private:
  SecondOrderError last_;  // for guesses, where a step is worth one
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
