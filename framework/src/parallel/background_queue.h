/// Jobs that are done in another thread.
#pragma once

#include <condition_variable>
#include <deque>
#include <exception>
#include <functional>
#include <mutex>
#include <thread>

namespace deform {

/// Does jobs one after another, in the order in which they came, in a thread of its own; few may
/// wait. One that throws is the last: those behind it are not done. To be used from one thread.
class BackgroundQueue {
 public:
  BackgroundQueue() = default;
  /// Waits until nothing is left to do; what was thrown and not asked for is lost.
  ~BackgroundQueue();
  BackgroundQueue(const BackgroundQueue&) = delete;
  BackgroundQueue& operator=(const BackgroundQueue&) = delete;

  /// Waits while too many jobs wait. Throws what an earlier one threw, once.
  void add(std::function<void()> job);
  /// Waits until nothing is left to do. Throws likewise.
  void drain();

 private:
  void work();
  void throw_failure();

  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<std::function<void()>> jobs_;  // the first is being done
  std::exception_ptr failure_;
  bool ends_ = false;
  std::thread thread_;  // begins with the first job
};

}  // namespace deform
