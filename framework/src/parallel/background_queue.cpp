#include "parallel/background_queue.h"

#include <utility>

#include "plugin/process_end.h"

namespace deform {
namespace {

/// Each waiting job keeps a frame's numbers in memory.
constexpr std::size_t kMostJobs = 4;

}  // namespace

BackgroundQueue::~BackgroundQueue() {
  if (!thread_.joinable()) return;
  {
    const std::lock_guard lock(mutex_);
    ends_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

void BackgroundQueue::add(std::function<void()> job) {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [&] { return jobs_.size() < kMostJobs || failure_ != nullptr; });
  throw_failure();
  if (!thread_.joinable()) thread_ = std::thread([this] { work(); });  // may throw: before the job
  jobs_.push_back(std::move(job));
  changed_.notify_all();
}

void BackgroundQueue::drain() {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [&] { return jobs_.empty(); });
  if (!was_told_) throw_failure();
}

bool BackgroundQueue::drain_within(std::chrono::milliseconds longest) {
  std::unique_lock lock(mutex_);
  return changed_.wait_for(lock, longest, [&] { return jobs_.empty(); });
}

void BackgroundQueue::require_success() {
  const std::lock_guard lock(mutex_);
  throw_failure();
}

void BackgroundQueue::throw_failure() {
  if (failure_ == nullptr) return;
  was_told_ = true;
  std::rethrow_exception(failure_);
}

void BackgroundQueue::work() {
  prepare_thread_for_crashes();
  std::unique_lock lock(mutex_);
  for (;;) {
    changed_.wait(lock, [&] { return ends_ || !jobs_.empty(); });
    if (jobs_.empty()) return;
    std::function<void()>& job = jobs_.front();
    lock.unlock();
    std::exception_ptr thrown;
    try {
      job();
      job = nullptr;  // what it keeps goes outside of the lock
    } catch (...) {
      thrown = std::current_exception();
    }
    lock.lock();
    if (thrown != nullptr) {
      failure_ = thrown;
      jobs_.clear();
    } else {
      jobs_.pop_front();
    }
    changed_.notify_all();
  }
}

}  // namespace deform
