/// Adds the time of a scope to a sum, and to the active profile as a part.
#pragma once

#include <chrono>
#include <string_view>

#include "profile/profile.h"

namespace deform {

/// Within another one of the same thread it stops that one: each moment is of one sum, and all of
/// them together are no more than the time that went by.
class Stopwatch {
 public:
  Stopwatch(double& seconds, std::string_view part)
      : span_(part), seconds_(seconds), outer_(innermost_), start_(Clock::now()) {
    innermost_ = this;
  }
  ~Stopwatch() {
    const Clock::duration passed = Clock::now() - start_;
    seconds_ += std::chrono::duration<double>(passed - within_).count();
    if (outer_ != nullptr) outer_->within_ += passed;
    innermost_ = outer_;
  }
  Stopwatch(const Stopwatch&) = delete;
  Stopwatch& operator=(const Stopwatch&) = delete;

 private:
  using Clock = std::chrono::steady_clock;
  static constinit thread_local Stopwatch* innermost_;

  Span span_;
  double& seconds_;
  Stopwatch* outer_;
  Clock::duration within_{0};  // that those within this one have counted
  Clock::time_point start_;
};

}  // namespace deform
