/// Adds the time of a scope to a sum, and to the active profile as a part.
#pragma once

#include <chrono>
#include <string_view>

#include "profile/profile.h"

namespace deform {

class Stopwatch {
 public:
  Stopwatch(double& seconds, std::string_view part)
      : span_(part), seconds_(seconds), start_(Clock::now()) {}
  ~Stopwatch() { seconds_ += std::chrono::duration<double>(Clock::now() - start_).count(); }
  Stopwatch(const Stopwatch&) = delete;
  Stopwatch& operator=(const Stopwatch&) = delete;

 private:
  using Clock = std::chrono::steady_clock;
  Span span_;
  double& seconds_;
  Clock::time_point start_;
};

}  // namespace deform
