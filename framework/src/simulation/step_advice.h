/// What makes steps hard, for the log.
#pragma once

#include <set>
#include <string>
#include <vector>

#include "deform/solve/system.h"

namespace deform {

/// Says once for each cause, with the first step that shows it, why Newton's method takes long, or
/// why steps are halved, and what may help. A step is hard that took more than kMany iterations
/// for each of its parts, or half as many where parts were given up. Where bending takes the
/// normal, a surface that is folded more sharply than its samples resolve is the cause whatever
/// else is. Warns once of nodes inside of a body, which only bodies that close on the surface
/// between them bring about.
class StepAdvice {
 public:
  static constexpr long kMany = 25;

  /// `system` must live as long.
  explicit StepAdvice(const System& system) : system_(&system) {}
  /// A step of that number has been taken to a state.
  void look(long step, const State& state);

 private:
  void look_at_iterations(long step, const State& state);
  [[nodiscard]] bool is_folded(long step, const State& state);
  void look_for_squeezed(long step, const State& state);

  const System* system_;
  std::vector<NodeContact> inside_;  // kept for its memory
  bool has_warned_ = false;
  std::set<std::string> said_;
};

}  // namespace deform
