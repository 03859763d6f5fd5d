/// Jobs that are done in another thread.
#pragma once

#include <chrono>
#include <condition_variable>
#include <deque>
#include <exception>
#include <functional>
#include <mutex>
#include <thread>

namespace deform {

/// Does jobs one after another, in the order in which they came, in a thread of its own; few may
/// wait. One that throws is the last: those behind it are not done, and none is taken any more. To
/// be used from one thread.
class BackgroundQueue {
 public:
  BackgroundQueue() = default;
  /// Waits until nothing is left to do; what was thrown and never asked for is lost.
  ~BackgroundQueue();
  BackgroundQueue(const BackgroundQueue&) = delete;
  BackgroundQueue& operator=(const BackgroundQueue&) = delete;

  /// Waits while too many jobs wait. Throws what an earlier one threw.
  void add(std::function<void()> job);
  /// Throws what a job threw so far.
  void require_success();
  /// Waits until nothing is left to do. Throws what a job threw, unless it has been thrown before.
  void drain();
  /// Waits that long at most; returns whether nothing is left to do. Throws nothing; from any
  /// thread.
  [[nodiscard]] bool drain_within(std::chrono::milliseconds longest);

 private:
  void work();
  void throw_failure();

  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<std::function<void()>> jobs_;  // the first is being done
  std::exception_ptr failure_;
  bool was_told_ = false;  // the failure
  bool ends_ = false;
  std::thread thread_;  // begins with the first job
};

}  // namespace deform
