/// Ends what goes on after a run was told to stop.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <thread>

namespace deform {

/// Looks, in a thread of its own, whether a run is interrupted while it does something that may
/// take long. What ends by itself within kPatience does so and counts; then `stop` becomes true,
/// which a System heeds. What has not ended kLastResort after the run was told, because it asks
/// nobody (a factorisation, a plugin that hangs), is given up; what begins then still has kLeast.
class StepWatch {
 public:
  using Clock = std::chrono::steady_clock;
  static constexpr std::chrono::milliseconds kPatience{500}, kLastResort{1500}, kLeast{100};

  /// Null: nothing is watched.
  explicit StepWatch(const std::atomic<bool>* interrupted);
  ~StepWatch();
  StepWatch(const StepWatch&) = delete;
  StepWatch& operator=(const StepWatch&) = delete;

  /// Whether what is being done is to end; only ever true within a Span.
  [[nodiscard]] const std::atomic<bool>& stop() const { return stop_; }

  /// What is watched while this lives; one at a time. `give_up` is called at most once, in the
  /// watch's thread, while the other one is still within the span, which it does not leave before
  /// `give_up` returns.
  class Span {
   public:
    Span(StepWatch& watch, const std::function<void()>& give_up);
    ~Span();
    Span(const Span&) = delete;
    Span& operator=(const Span&) = delete;

   private:
    StepWatch& watch_;
  };

 private:
  void watch(const std::atomic<bool>& interrupted);

  std::mutex mutex_;
  std::condition_variable changed_;
  const std::function<void()>* give_up_ = nullptr;  // of the span; null outside of one
  Clock::time_point begun_;                         // the span
  bool ends_ = false;
  std::atomic<bool> stop_ = false;
  std::thread thread_;
};

}  // namespace deform
