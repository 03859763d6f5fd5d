/// Adds the time of a scope to the thread's StepTimes, and to the active profile as a part.
#pragma once

#include <chrono>
#include <string_view>

#include "deform/solve/step_times.h"

#include "profile/profile.h"

namespace deform {

/// Within another one of the same thread it stops that one: each moment is of one sum, and all of
/// them together are no more than the time that went by.
class Stopwatch {
 public:
  Stopwatch(double StepTimes::*part, std::string_view name)
      : span_(name), times_(active_), part_(part), outer_(innermost_), start_(Clock::now()) {
    innermost_ = this;
  }
  ~Stopwatch() {
    const Clock::duration passed = Clock::now() - start_;
    if (times_ != nullptr)
      times_->*part_ += std::chrono::duration<double>(passed - within_).count();
    if (outer_ != nullptr) outer_->within_ += passed;
    innermost_ = outer_;
  }
  Stopwatch(const Stopwatch&) = delete;
  Stopwatch& operator=(const Stopwatch&) = delete;

 private:
  friend class TimesAddedTo;
  using Clock = std::chrono::steady_clock;
  static constinit thread_local Stopwatch* innermost_;
  static constinit thread_local StepTimes* active_;

  Span span_;
  StepTimes* times_;
  double StepTimes::*part_;
  Stopwatch* outer_;
  Clock::duration within_{0};  // that those within this one have counted
  Clock::time_point start_;
};

}  // namespace deform
