#include <array>

#include <deform/solve/stepped_integrator.h>

namespace {
using namespace deform;

struct Parameters : StepControl {
  static void declare(Declaration<Parameters>& d) { StepControl::declare(d); }
};

constexpr int kStages = 5;
/// The classical method, and a fifth stage for a result of third order to compare with.
constexpr std::array<double, kStages> kTime{0, 0.5, 0.5, 1, 0.75};
constexpr std::array<std::array<double, kStages>, kStages> kBefore{
    {{}, {0.5}, {0, 0.5}, {0, 0, 1}, {5.0 / 32, 7.0 / 32, 13.0 / 32, -1.0 / 32}}};
constexpr std::array<double, kStages> kWeight{1.0 / 6, 1.0 / 3, 1.0 / 3, 1.0 / 6, 0};
constexpr std::array<double, kStages> kThirdOrder{-0.5, 7.0 / 3, 7.0 / 3, 13.0 / 6, -16.0 / 3};

/// ṙ = v, TᵀMT v̇ = Tᵀ(f(r, v, t) − Γ v): explicit, fourth order, stable for steps below 2.8/ω of
/// the stiffest mode; for references.
class RungeKutta final : public SteppedIntegrator {
 public:
  RungeKutta(const Parameters& p, const Setup& /*setup*/) : SteppedIntegrator(p) {}

  [[nodiscard]] Solves solves() const override { return Solves::nothing; }

 protected:
  [[nodiscard]] Attempt attempt(System& system, const State& from, double h, State& to) override {
    const int stages = with_error() ? kStages : kStages - 1;
    for (int i = 0; i < stages; ++i) {
      stage_ = from;
      add(kBefore[static_cast<std::size_t>(i)], i, h, stage_);
      stage_.time = from.time + kTime[static_cast<std::size_t>(i)] * h;
      put_on_constraints(system, i == 0 ? -h : h, stage_);  // velocities of this step
      stage_.time = within_step(stage_.time, from.time, h);
      system.evaluator().force(stage_, force_);
      for (int c = 0; c < 3; ++c) force_.col(c) -= system.damping().cwiseProduct(stage_.v.col(c));
      system.mass_matrix().accelerate(force_, acceleration_[static_cast<std::size_t>(i)]);
      velocity_[static_cast<std::size_t>(i)] = stage_.v;
    }
    to = from;
    add(kWeight, stages, h, to);
    to.time = from.time + h;
    put_on_constraints(system, h, to);
    if (!with_error()) return {};
    State third = from;
    add(kThirdOrder, stages, h, third);
    third.time = to.time;
    put_on_constraints(system, h, third);
    return {"", to.r - third.r, false};
  }
  [[nodiscard]] int local_order() const override { return 4; }

 private:
  /// state += h Σ_j b_j k_j over the first stages.
  void add(const std::array<double, kStages>& b, int stages, double h, State& state) const {
    for (std::size_t j = 0; j < static_cast<std::size_t>(stages); ++j) {
      if (b[j] == 0) continue;
      state.r += h * b[j] * velocity_[j];
      state.v += h * b[j] * acceleration_[j];
    }
  }
  static void put_on_constraints(const System& system, double reach, State& state) {
    system.constraints().prescribe(state.time, state.r);
    system.constraints().prescribe_velocity(state.time, reach, state.v);
  }

  State stage_;
  NodeVectors force_;
  std::array<NodeVectors, kStages> velocity_, acceleration_;
};

}  // namespace

DEFORM_PLUGIN(RungeKutta, Parameters, .name = "runge_kutta", .version = "1.0",
              .summary =
                  "explicit, fourth order: the reference for others on problems that are "
                  "not stiff",
              .formula = "y⁺ = y + h (k₁ + 2 k₂ + 2 k₃ + k₄)/6",
              .source =
                  "Kutta 1901; error by Zonneveld's fifth stage: Hairer, Nørsett, Wanner, "
                  "Solving Ordinary Differential Equations I, II.4")
