/// Whether a run with steps of its own choice gets on.
#pragma once

#include <chrono>
#include <string>

namespace deform {

/// Counts the tries at parts of a scene's step and warns, once, of a run that crawls: one that
/// takes more and more parts, by which a second of simulated time would take an hour. Changes no
/// result.
class Headway {
 public:
  /// A step of the scene begins, whose length is `step` [s].
  void begin(double step);
  /// A part was tried, after which `gained` [s] of it are done; `failure`: "" when it was taken.
  void tried(double gained, const std::string& failure);
  void end();

  /// Since the step began.
  [[nodiscard]] long tries() const { return tries_; }
  [[nodiscard]] double gained() const { return gained_; }
  [[nodiscard]] bool has_warned() const { return warned_; }

 private:
  using Clock = std::chrono::steady_clock;
  [[nodiscard]] bool crawls(double seconds) const;
  void warn(double seconds) const;

  Clock::time_point begun_;
  double step_ = 0, gained_ = 0;  // [s]
  long tries_ = 0, failures_ = 0;
  long fewest_ = 1;  // tries of an earlier step
  bool knows_earlier_ = false, warned_ = false;
  std::string failure_;  // the last
};

}  // namespace deform
