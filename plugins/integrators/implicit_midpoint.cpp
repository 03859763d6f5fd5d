#include "implicit.h"
#include "second_order_error.h"

namespace {
using namespace deform;

struct Parameters : ImplicitParameters {
  static void declare(Declaration<Parameters>& d) { ImplicitParameters::declare(d); }
};

/// M (v⁺ − v)/h = f(r_m, v_m, t + h/2) − Γ v_m with r_m = (r + r⁺)/2, v_m = (r⁺ − r)/h = (v +
/// v⁺)/2: a stage of length h/2, then as far again. Second order; keeps momentum and angular
/// momentum. Energies that know strains are those of the mean of both ends' strains, not of the
/// mean of both ends' positions, which a turn shrinks: their forces do the work of the change of
/// energy, so that this is kept, too, for steps of any size (StepStrains::average_from), where
/// it is quadratic in strains and loads have potentials of at most second degree. Others are taken
/// at the middle, and their energy drifts at second order.
class ImplicitMidpoint final : public ImplicitIntegrator {
 public:
  ImplicitMidpoint(const Parameters& p, const Setup& /*setup*/) : ImplicitIntegrator(p) {}

  void save(Memory& memory) const override {
    ImplicitIntegrator::save(memory);
    error_.save(memory);
  }
  void load(const Memory& memory) override {
    ImplicitIntegrator::load(memory);
    error_.load(memory);
  }

 protected:
  [[nodiscard]] Attempt attempt(System& system, const State& from, double h, State& to) override {
    const double end = from.time + h;
    if (with_error() && !error_.is_known()) error_.start(acceleration(system, from, h));
    begin_stage(from, h);
    stage_.tau = h / 2;
    stage_.reach = 2;
    stage_.by_strains = false;
    stage_.averages_strains = true;
    error_.extrapolate(from, h, SecondOrderError::kOfSecondOrder, target_);
    stage_.prediction = 0.5 * (from.r + target_);
    // What it promises to keep it keeps to the tolerance; where there is contact, it promises none.
    if (system.contact().bodies() > 0) stage_.error_per_change = error_.per_change(h, kError);
    system.constraints().prescribe(end, target_);
    to.r = 0.5 * (from.r + target_);
    std::string failure = newton_.solve(system, stage_, to);
    if (!failure.empty()) return {std::move(failure), {}, false};
    to.r = 2 * to.r - from.r;
    to.v = 2 * to.v - from.v;
    to.time = end;
    std::vector<ContactImpulse> contact = newton_.settle(system, stage_, from, h, to);
    system.constraints().prescribe(end, to.r);
    system.constraints().prescribe_velocity(end, h, to.v);
    return {"", with_error() ? error_.of(from, to, h, kError) : NodeVectors(),
            newton_.resolves_contacts(), std::move(contact)};
  }
  [[nodiscard]] int local_order() const override { return 3; }
  void accept(const State& from, const State& to) override { error_.accept(from, to); }
  void forget_history() override { error_.forget(); }

 private:
  static constexpr double kError = 1.0 / 12;  // C

  /// At the beginning of a step, contact left out.
  [[nodiscard]] static NodeVectors acceleration(System& system, State from, double h) {
    from.time = within_step(from.time, from.time, h);
    NodeVectors force = system.evaluator().force(from), a;
    for (int c = 0; c < 3; ++c) force.col(c) -= system.damping().cwiseProduct(from.v.col(c));
    system.mass_matrix().accelerate(force, a);
    return a;
  }

  SecondOrderError error_;
  NodeVectors target_;  // guess of the step's end
};

}  // namespace

DEFORM_PLUGIN(
    ImplicitMidpoint, Parameters, .name = "implicit_midpoint", .version = "1.0",
    .summary =
        "implicit, second order, without damping of its own: for long flights and "
        "vibrations; keeps momenta, and the energy of quadratic energies and potentials",
    .formula =
        "M (v⁺ − v)/h = f((r + r⁺)/2, (v + v⁺)/2) − Γ (v + v⁺)/2, "
        "r⁺ = r + h (v + v⁺)/2; stress at (G + G⁺)/2, (B + B⁺)/2",
    .source =
        "Hairer, Lubich, Wanner, Geometric Numerical Integration, IV.2, VI.4; mean strains: "
        "Simo & Tarnow 1992")
