/// A progress bar on stderr, and a logger that does not write into it.
#pragma once

#include <chrono>
#include <mutex>
#include <string>

namespace deform::app {

/// One line on stderr that is drawn over and over: percent, steps, steps/s, time to finish.
/// Thread-safe.
class ProgressBar {
 public:
  /// From here on `update` draws, if stderr is a terminal.
  void begin();
  /// Draws at most ten times a second.
  void update(long done, long total);
  void end();
  /// Writes a whole line to stderr, above the bar if there is one.
  void write_above(const std::string& line);

 private:
  using Clock = std::chrono::steady_clock;
  void erase();
  void draw();

  bool visible_ = false;
  std::mutex mutex_;
  std::string drawn_;
  Clock::time_point start_, next_;
};

/// The same for another program: a line "progress DONE" on stdout, at most ten times a second.
class ProgressLines {
 public:
  void operator()(long done, long total);

 private:
  std::chrono::steady_clock::time_point next_;
};

/// "41 s", "3:07 min" or "1:02:03 h".
[[nodiscard]] std::string format_duration(double seconds);

/// Makes the default logger write warnings to stderr, above the bar, and everything to other sinks
/// that join it (log.txt of a run). The bar must live as long as the logger is used.
void log_above(ProgressBar& bar);

}  // namespace deform::app
