#include "implicit.h"
#include "second_order_error.h"

namespace {
using namespace deform;

struct Parameters : ImplicitParameters {
  static void declare(Declaration<Parameters>& d) { ImplicitParameters::declare(d); }
};

/// Steps longer than this many of the one before are cut: the formula is stable below 1 + √2.
constexpr double kMostGrowth = 2;

/// Backward differences over two steps, h⁻ and h = ω h⁻:
///   y⁺ = ((1 + ω)² y − ω² y⁻)/(1 + 2ω) + τ ẏ⁺, τ = h (1 + ω)/(1 + 2ω), for y = r and y = v.
/// Second order, damps what it does not resolve. The first step, and those after an impact, are
/// backward Euler's.
class Bdf2 final : public ImplicitIntegrator {
 public:
  Bdf2(const Parameters& p, const Setup& /*setup*/) : ImplicitIntegrator(p) {}

  void save(Memory& memory) const override {
    ImplicitIntegrator::save(memory);
    error_.save(memory);
    if (has_before_) put(memory, "before", before_);
    memory.put("touched", {touched_.begin(), touched_.end()});
  }
  void load(const Memory& memory) override {
    ImplicitIntegrator::load(memory);
    error_.load(memory);
    has_before_ = has(memory, "before");
    if (has_before_) before_ = get(memory, "before");
    if (has_before_ && before_.r.rows() != known_nodes(memory))
      throw InputError("the checkpoint's \"before\" has another number of nodes");
    touched_.clear();
    const auto touched = memory.entries().find("touched");
    if (touched == memory.entries().end()) return;
    for (const double node : touched->second) {
      if (!(node >= 0 && node < static_cast<double>(known_nodes(memory))))
        throw InputError("the checkpoint's \"touched\" has a node that is none");
      touched_.push_back(static_cast<Index>(node));
    }
  }

 protected:
  /// Of the state that the memory's last step ended with.
  [[nodiscard]] static Index known_nodes(const Memory& memory) {
    const auto last = memory.entries().find("last.r");
    return last == memory.entries().end() ? 0 : static_cast<Index>(last->second.size() / 3);
  }

  [[nodiscard]] Attempt attempt(System& system, const State& from, double h, State& to) override {
    const double end = from.time + h;
    begin_stage(from, h);
    const double omega = has_before_ ? h / (from.time - before_.time) : 0;
    const bool goes_on = has_before_ && omega <= kMostGrowth * (1 + 1e-9);
    if (goes_on) {
      const double now = (1 + omega) * (1 + omega) / (1 + 2 * omega);
      const double earlier = omega * omega / (1 + 2 * omega);
      stage_.r_base = now * from.r - earlier * before_.r;
      stage_.v_base = now * from.v - earlier * before_.v;
      stage_.tau = h * (1 + omega) / (1 + 2 * omega);
      stage_.s = -earlier;
      stage_.earlier = before_.r;
    }
    error_.extrapolate(from, h, SecondOrderError::kOfSecondOrder, to.r);
    system.prescribe(end, to.r);
    std::string failure = newton_.solve(system, stage_, to);
    if (!failure.empty()) return {std::move(failure), {}, false};
    to.time = end;
    const double C = (1 + omega) * (1 + omega) / (6 * omega * (1 + 2 * omega));
    Attempt done{"", {}, newton_.resolves_contacts()};
    if (with_error())
      done.error = goes_on ? error_.of(from, to, h, C) : NodeVectors(h / 2 * (to.v - from.v));
    return done;
  }
  [[nodiscard]] int local_order() const override { return has_before_ ? 3 : 2; }

  void accept(const State& from, const State& to) override {
    error_.accept(from, to);
    before_ = from;
    std::vector<Index> touching;
    for (const Touch& touch : newton_.touching()) touching.push_back(touch.node);
    has_before_ = touching == touched_;
    touched_ = std::move(touching);
  }
  void forget() override {
    ImplicitIntegrator::forget();
    error_.forget();
    has_before_ = false;
    touched_.clear();
  }

 private:
  SecondOrderError error_;
  bool has_before_ = false;
  State before_;                // where the last step began
  std::vector<Index> touched_;  // nodes that colliders held in the last step
};

}  // namespace

DEFORM_PLUGIN(Bdf2, Parameters, .name = "bdf2", .version = "1.0",
              .summary =
                  "implicit, second order, for steps of any size; damps little of what it "
                  "resolves and all of what it does not",
              .formula = "(3 y⁺ − 4 y + y⁻)/(2h) = ẏ⁺ for y = r, v (equal steps)",
              .source = "Hairer, Nørsett, Wanner, Solving Ordinary Differential Equations I, III.5")
