/// What makes steps hard, for the log.
#pragma once

#include <set>
#include <string>

#include "deform/solve/system.h"

namespace deform {

/// Says once for each cause, with the first step that shows it, why Newton's method takes long, or
/// why steps are halved, and what may help. A step is hard that was halved or that took more than
/// kMany iterations for each of its parts.
class StepAdvice {
 public:
  static constexpr long kMany = 25;

  explicit StepAdvice(bool has_bodies) : has_bodies_(has_bodies) {}
  /// A step of that number has been taken.
  void look(long step, const StepReport& report);

 private:
  bool has_bodies_;
  std::set<std::string> said_;
};

}  // namespace deform
