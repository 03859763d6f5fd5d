#include "solve/stepping/headway.h"

#include <algorithm>

#include <fmt/format.h>

#include "deform/log.h"

namespace deform {
namespace {

/// Fewer tries at parts of a step are not worth a look at the clock.
constexpr long kMany = 100;
/// Tries of a step, relative to those of the one that took the fewest, that count as growing.
constexpr long kGrowth = 4;
/// Seconds of computing for one of simulated time, and for the step, that count as crawling.
constexpr double kHour = 3600, kLong = 1;

}  // namespace

void Headway::begin(double step) {
  begun_ = Clock::now();
  step_ = step;
  gained_ = 0;
  tries_ = failures_ = 0;
}

void Headway::tried(double gained, const std::string& failure) {
  ++tries_;
  gained_ = gained;
  if (!failure.empty()) ++failures_, failure_ = failure;
  if (warned_ || tries_ % kMany != 0 || tries_ < kGrowth * fewest_) return;
  const double seconds = std::chrono::duration<double>(Clock::now() - begun_).count();
  if (!crawls(seconds)) return;
  warned_ = true;
  warn(seconds);
}

void Headway::end() {
  if (tries_ == 0) return;  // done before, by steps that went on beyond the scene's
  fewest_ = knows_earlier_ ? std::min(fewest_, tries_) : tries_;
  knows_earlier_ = true;
}

/// What is gained so far at the pace so far; before anything is gained, the time so far.
bool Headway::crawls(double seconds) const {
  if (!(gained_ > 0)) return seconds >= kLong;
  const double pace = seconds / gained_;
  return pace >= kHour && pace * step_ >= kLong;
}

void Headway::warn(double seconds) const {
  const std::string pace =
      gained_ > 0 ? fmt::format("a second of simulated time would take {:.2g} hours at this pace",
                                seconds / gained_ / kHour)
                  : "nothing is gained so far";
  const std::string reason =
      failures_ > 0 ? fmt::format("; {} of them failed, the last because: {}", failures_, failure_)
                    : "";
  log::warn(fmt::format(
      "the run makes no headway: {} parts of a step of {:.3g} s were tried in {:.3g} s, {}{}. What "
      "may help: a shorter /integrator/step where steps fail, a larger 'error' where that is what "
      "shortens them, 'backward_euler', which damps most, softer or thicker material, loads that "
      "grow more slowly",
      tries_, step_, seconds, pace, reason));
}

}  // namespace deform
