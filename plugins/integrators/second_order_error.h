/// Local errors of second-order methods by comparison with an extrapolation (Milne's device).
#pragma once

#include <cmath>
#include <optional>
#include <vector>

#include <deform/solve/system.h>

namespace deform {

/// Remembers the last step's acceleration.
class SecondOrderError {
 public:
  static constexpr double kOfSecondOrder = 0.5;

  void accept(const State& from, const State& to) {
    step_ = to.time - from.time;
    acceleration_ = (to.v - from.v) / step_;
  }
  /// Where there is no step before: the acceleration at the time itself, which counts as that of a
  /// last step of length 0.
  void start(const NodeVectors& acceleration) {
    step_ = 0;
    acceleration_ = acceleration;
  }
  void forget() { acceleration_.resize(0, 3); }
  [[nodiscard]] bool is_known() const { return acceleration_.rows() > 0; }

  /// Makes r: r + h v + `share` h² a with a of the middle of the last step, of length h⁻: for
  /// a share of one half it differs from the solution by (1/6 + 1/(4ω)) h³ r⃛, ω = h/h⁻.
  void extrapolate(const State& from, double h, double share, NodeVectors& r) const {
    r = from.r + h * from.v;
    if (is_known()) r += share * h * h * acceleration_;
  }
  /// The local error of a method whose result r⁺ is wrong by +C h³ r⃛, by r⁺'s difference from the
  /// extrapolation with a share of one half; 0 where nothing is known.
  [[nodiscard]] double per_change(double h, double C) const {
    const double omega = h / step_;
    return is_known() ? C / (C + 1.0 / 6 + 1 / (4 * omega)) : 0;
  }
  /// Local error of a method whose result r⁺ is wrong by +C h³ r⃛; empty where nothing is known.
  [[nodiscard]] NodeVectors of(const State& from, const State& to, double h, double C) const {
    if (!is_known()) return {};
    NodeVectors guess;
    extrapolate(from, h, kOfSecondOrder, guess);
    return per_change(h, C) * (to.r - guess);
  }

  void save(Memory& memory) const {
    if (is_known())
      memory.put("acceleration",
                 {acceleration_.data(), acceleration_.data() + acceleration_.size()});
    memory.put("last_step", {step_});
  }
  void load(const Memory& memory) {
    step_ = memory.get("last_step", 1).front();
    forget();
    if (!memory.entries().contains("acceleration")) return;
    // Of as many nodes as the state of the step that it is known from.
    const auto state = memory.entries().find("last.r");
    const std::vector<double>& known =
        memory.get("acceleration", state == memory.entries().end() ? 0 : state->second.size());
    acceleration_ =
        Eigen::Map<const NodeVectors>(known.data(), static_cast<Index>(known.size() / 3), 3);
    if (!acceleration_.allFinite() || !(step_ > 0) || !std::isfinite(step_))
      throw InputError("the checkpoint's \"acceleration\" is not finite, or of no step");
  }

 private:
  double step_ = 0;           // [s]
  NodeVectors acceleration_;  // (N × 3) [m/s²]
};

}  // namespace deform
