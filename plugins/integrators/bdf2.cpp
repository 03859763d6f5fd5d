#include <algorithm>
#include <numbers>
#include <optional>

#include "implicit.h"
#include "second_order_error.h"

namespace {
using namespace deform;

struct Parameters : ImplicitParameters {
  static void declare(Declaration<Parameters>& d) { ImplicitParameters::declare(d); }
};

/// Steps longer than this many of the one before start anew: the formula is stable below 1 + √2.
constexpr double kMostGrowth = 2;
/// γ of the two-stage step.
constexpr double kGamma = 1 - 1 / std::numbers::sqrt2;

/// Backward differences over two steps, h⁻ and h = ω h⁻:
///   y⁺ = ((1 + ω)² y − ω² y⁻)/(1 + 2ω) + τ ẏ⁺, τ = h (1 + ω)/(1 + 2ω), for y = r and y = v.
/// Second order, damps what it does not resolve. Steps without one before that they could go on
/// from (the first, and those after a break) have two stages of backward Euler's kind (Alexander
/// 1977):
///   y₁ = y + γ h ẏ₁, y⁺ = y + h ((1 − γ) ẏ₁ + γ ẏ⁺), γ = 1 − 1/√2,
/// of second order, too, and L-stable. Those with an impact and after one are backward Euler's: the
/// second stage would go on with the change of velocity that the first one saw.
class Bdf2 final : public ImplicitIntegrator {
 public:
  Bdf2(const Parameters& p, const Setup& /*setup*/) : ImplicitIntegrator(p) {}

  void save(Memory& memory) const override {
    ImplicitIntegrator::save(memory);
    error_.save(memory);
    if (has_before_) put(memory, "before", before_);
    memory.put("after_impact", {after_impact_ ? 1.0 : 0.0});
    memory.put("touched", {last_active_.begin(), last_active_.end()});
    last_contact_.save(memory);
  }
  void load(const Memory& memory) override {
    ImplicitIntegrator::load(memory);
    error_.load(memory);
    has_before_ = has(memory, "before");
    if (has_before_) before_ = get(memory, "before");
    if (has_before_ && before_.r.rows() != known_nodes(memory))
      throw InputError("the checkpoint's \"before\" has another number of nodes");
    after_impact_ = memory.get("after_impact", 1).front() != 0;
    last_contact_.clear();
    if (known_nodes(memory) > 0) last_contact_.load(memory, known_nodes(memory));
    last_active_.clear();
    const auto touched = memory.entries().find("touched");
    if (touched == memory.entries().end()) return;
    for (const double node : touched->second) {
      if (!(node >= 0 && node < static_cast<double>(known_nodes(memory))))
        throw InputError("the checkpoint's \"touched\" has a node that is none");
      last_active_.push_back(static_cast<Index>(node));
    }
  }

 protected:
  /// Of the state that the memory's last step ended with.
  [[nodiscard]] static Index known_nodes(const Memory& memory) {
    const auto last = memory.entries().find("last.r");
    return last == memory.entries().end() ? 0 : static_cast<Index>(last->second.size() / 3);
  }

  [[nodiscard]] Attempt attempt(System& system, const State& from, double h, State& to) override {
    Attempt done = any_attempt(system, from, h, to);
    contact_.clear();
    contact_.add(system.mass(), done.contact, from.v, to.v, h);
    return done;
  }
  [[nodiscard]] int local_order() const override { return order_; }

  void accept(const State& from, const State& to) override {
    error_.accept(from, to);
    before_ = from;
    has_before_ = active_ == last_active_;
    after_impact_ = !has_before_;
    last_active_ = active_;
    std::swap(last_contact_, contact_);
  }
  void forget() override {
    ImplicitIntegrator::forget();
    after_impact_ = false;
    last_active_.clear();
  }
  void forget_history() override {
    error_.forget();
    has_before_ = false;
  }

 private:
  Attempt any_attempt(System& system, const State& from, double h, State& to) {
    const double omega = has_before_ ? h / (from.time - before_.time) : 0;
    if (has_before_ && omega <= kMostGrowth * (1 + 1e-9))
      return two_steps(system, from, h, omega, to);
    if (!after_impact_) {
      std::optional<Attempt> done = two_stages(system, from, h, to);
      if (done) return std::move(*done);
      to = from;
    }
    return euler(system, from, h, to);
  }

  Attempt two_steps(System& system, const State& from, double h, double omega, State& to) {
    begin_stage(from, h);
    const double now = (1 + omega) * (1 + omega) / (1 + 2 * omega);
    const double earlier = omega * omega / (1 + 2 * omega);
    stage_.r_base = now * from.r - earlier * before_.r;
    stage_.v_base = now * from.v - earlier * before_.v;
    stage_.tau = h * (1 + omega) / (1 + 2 * omega);
    stage_.time = within_step(stage_.end, from.time, h);
    stage_.s = -earlier;
    stage_.earlier = before_.r;
    order_ = 3;
    const double C = (1 + omega) * (1 + omega) / (6 * omega * (1 + 2 * omega));
    error_.extrapolate(from, h, SecondOrderError::kOfSecondOrder, to.r);
    stage_.prediction = to.r;
    stage_.error_per_change = error_.per_change(h, C);
    std::string failure = solve(system, to);
    if (!failure.empty()) return {std::move(failure), {}, false};
    std::vector<ContactImpulse> contact = find_contacts(system, from, h, to);
    // v⁺ − v has ω²/(1 + 2ω) of the last step's change of velocity.
    add_scaled(system, last_contact_, earlier, contact);
    return {"", with_error() ? error_.of(from, to, h, C) : NodeVectors(), true, std::move(contact)};
  }

  /// Nothing where contact begins or ends within the step.
  std::optional<Attempt> two_stages(System& system, const State& from, double h, State& to) {
    const double part = kGamma * h;
    begin_stage(from, part);
    stage_.time = stage_.end;
    error_.extrapolate(from, part, SecondOrderError::kOfSecondOrder, to.r);
    std::string failure = solve(system, to);
    if (!failure.empty()) return Attempt{std::move(failure), {}, false};
    if (newton_.active_contacts() != last_active_) return std::nullopt;
    ContactReport first_contact;
    first_contact.add(system.mass(), newton_.impulses(system, stage_), from.v, to.v, part);

    const NodeVectors first = (to.v - from.v) / part;  // acceleration of the first stage
    const double weight = (1 - kGamma) / kGamma;       // of what the first stage changed
    stage_.r_base = from.r + weight * (to.r - from.r);
    stage_.v_base = from.v + weight * (to.v - from.v);
    stage_.s = weight;
    stage_.earlier = to.r;
    stage_.end = from.time + h;
    stage_.time = within_step(stage_.end, from.time, h);
    to.r = from.r + h * from.v + h * h / 2 * first;
    failure = solve(system, to);
    if (!failure.empty()) return Attempt{std::move(failure), {}, false};
    std::vector<ContactImpulse> contact = find_contacts(system, from, h, to);
    if (active_ != last_active_) return std::nullopt;
    add_scaled(system, first_contact, weight, contact);

    order_ = 3;
    Attempt done{
        .failure = "", .error = {}, .resolved_contacts = true, .contact = std::move(contact)};
    // r⁺ is wrong by + C h³ r⃛, C = (1 − γ) γ² + γ/2 − 1/6; the stages' accelerations differ by
    // (1 − γ) h r⃛.
    constexpr double C = (1 - kGamma) * kGamma * kGamma + kGamma / 2 - 1.0 / 6;
    if (with_error())
      done.error = C / (1 - kGamma) * h * h * ((to.v - stage_.v_base) / stage_.tau - first);
    return done;
  }

  Attempt euler(System& system, const State& from, double h, State& to) {
    begin_stage(from, h);
    order_ = 2;
    stage_.prediction = from.r + h * from.v;
    stage_.error_per_change = 0.5;
    error_.extrapolate(from, h, SecondOrderError::kOfSecondOrder, to.r);
    std::string failure = solve(system, to);
    if (!failure.empty()) return {std::move(failure), {}, false};
    std::vector<ContactImpulse> contact = find_contacts(system, from, h, to);
    return {"", with_error() ? NodeVectors(h / 2 * (to.v - from.v)) : NodeVectors(), true,
            std::move(contact)};
  }

  /// From the guess in `to`, whose prescribed components become those of the stage's end.
  std::string solve(System& system, State& to) {
    system.constraints().prescribe(stage_.end, to.r);
    std::string failure = newton_.solve(system, stage_, to);
    to.time = stage_.end;
    return failure;
  }

  /// Velocities after contact at a step's end, and what colliders held in it. Returns the impulses
  /// that the stage and the law of impacts gave velocities.
  std::vector<ContactImpulse> find_contacts(System& system, const State& from, double h,
                                            State& to) {
    if (newton_.resolves_contacts()) {
      active_ = newton_.active_contacts();
      return newton_.settle(system, stage_, from, h, to);
    }
    std::vector<ContactImpulse> impulses = system.contact().resolve(from, h, to);
    active_.clear();
    for (const ContactImpulse& i : impulses) active_.push_back(i.node);
    std::ranges::sort(active_);
    active_.erase(std::unique(active_.begin(), active_.end()), active_.end());
    return impulses;
  }

  /// Adds a part of a step's impulses to others.
  static void add_scaled(const System& system, const ContactReport& of, double part,
                         std::vector<ContactImpulse>& to) {
    if (!of.any()) return;
    for (Index a = 0; a < system.nodes(); ++a) {
      const Vec3 normal = of.normal_impulse().row(a).transpose() / system.mass()[a];
      const Vec3 friction = of.friction_impulse().row(a).transpose() / system.mass()[a];
      const double size = normal.norm();
      if (size == 0 && friction.isZero(0)) continue;
      to.push_back({.node = a,
                    .normal = size > 0 ? Vec3(normal / size) : Vec3(Vec3::UnitZ()),
                    .normal_impulse = part * size,
                    .friction_impulse = part * friction});
    }
  }

  SecondOrderError error_;
  ContactReport contact_, last_contact_;  // of the last attempt, and of the last step
  int order_ = 2;                         // of the local error of the last attempt
  bool has_before_ = false, after_impact_ = false;
  State before_;                    // where the last step began
  std::vector<Index> last_active_;  // nodes that colliders held in the last step …
  std::vector<Index> active_;       // … and in the last attempt
};

}  // namespace

DEFORM_PLUGIN(
    Bdf2, Parameters, .name = "bdf2", .version = "1.0",
    .summary =
        "implicit, second order, for steps of any size; damps little of what it "
        "resolves and all of what it does not",
    .formula = "(3 y⁺ − 4 y + y⁻)/(2h) = ẏ⁺ for y = r, v (equal steps)",
    .source =
        "Hairer, Nørsett, Wanner, Solving Ordinary Differential Equations I, III.5; steps "
        "without history: Alexander 1977, SIAM J. Numer. Anal. 14, 1006")
