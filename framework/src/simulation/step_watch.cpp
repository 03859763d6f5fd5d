#include "simulation/step_watch.h"

#include <algorithm>

namespace deform {
namespace {

/// How often it looks.
constexpr std::chrono::milliseconds kPause{20};

}  // namespace

StepWatch::StepWatch(const std::atomic<bool>* interrupted) {
  if (interrupted != nullptr) thread_ = std::thread([this, interrupted] { watch(*interrupted); });
}

StepWatch::~StepWatch() {
  if (!thread_.joinable()) return;
  {
    const std::lock_guard lock(mutex_);
    ends_ = true;
  }
  changed_.notify_one();
  thread_.join();
}

void StepWatch::watch(const std::atomic<bool>& interrupted) {
  std::unique_lock lock(mutex_);
  const auto ends = [this] { return ends_; };
  while (!interrupted.load())
    if (changed_.wait_for(lock, kPause, ends)) return;
  const Clock::time_point told = Clock::now();
  do {
    if (give_up_ == nullptr) continue;
    const Clock::time_point now = Clock::now();
    stop_ = now >= std::max(told, begun_) + kPatience;
    if (now < std::max(told + kLastResort, begun_ + kLeast)) continue;
    (*give_up_)();  // under the lock: the span cannot end meanwhile
    return;
  } while (!changed_.wait_for(lock, kPause, ends));
}

StepWatch::Span::Span(StepWatch& watch, const std::function<void()>& give_up) : watch_(watch) {
  const std::lock_guard lock(watch_.mutex_);
  watch_.give_up_ = &give_up;
  watch_.begun_ = Clock::now();
}

StepWatch::Span::~Span() {
  const std::lock_guard lock(watch_.mutex_);
  watch_.give_up_ = nullptr;
  watch_.stop_ = false;
}

}  // namespace deform
