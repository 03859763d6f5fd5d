#include "simulation/step_watch.h"

#include <atomic>

#include <gtest/gtest.h>

namespace deform {
namespace {

using Clock = StepWatch::Clock;
using std::chrono::milliseconds;

TEST(StepWatch, StopsWhatGoesOnAfterItWasTold) {
  std::atomic<bool> interrupted = false, given_up = false;
  StepWatch watch(&interrupted);
  const std::function<void()> give_up = [&] { given_up = true; };
  {
    const StepWatch::Span span(watch, give_up);
    std::this_thread::sleep_for(milliseconds(60));
    EXPECT_FALSE(watch.stop());
    const Clock::time_point told = Clock::now();
    interrupted = true;
    while (!watch.stop()) std::this_thread::sleep_for(milliseconds(1));
    EXPECT_GE(Clock::now() - told, StepWatch::kPatience);
    EXPECT_FALSE(given_up);
    while (!given_up) std::this_thread::sleep_for(milliseconds(1));
    EXPECT_GE(Clock::now() - told, StepWatch::kLastResort);
  }
  EXPECT_FALSE(watch.stop());
}

TEST(StepWatch, LeavesAloneWhatEndsByItself) {
  std::atomic<bool> interrupted = true;
  StepWatch watch(&interrupted);
  std::this_thread::sleep_for(StepWatch::kPatience + milliseconds(100));
  const std::function<void()> give_up = [] { FAIL(); };
  const StepWatch::Span span(watch, give_up);
  std::this_thread::sleep_for(milliseconds(100));
  EXPECT_FALSE(watch.stop());  // it has begun only now
}

TEST(StepWatch, LeavesLittleTimeToWhatBeginsLate) {
  std::atomic<bool> interrupted = true, given_up = false;
  StepWatch watch(&interrupted);
  std::this_thread::sleep_for(StepWatch::kLastResort);
  const std::function<void()> give_up = [&] { given_up = true; };
  const Clock::time_point begun = Clock::now();
  const StepWatch::Span span(watch, give_up);
  while (!given_up) std::this_thread::sleep_for(milliseconds(1));
  EXPECT_GE(Clock::now() - begun, StepWatch::kLeast);
  EXPECT_LT(Clock::now() - begun, StepWatch::kLastResort);
}

TEST(StepWatch, WatchesNothingWhereNobodyInterrupts) {
  StepWatch watch(nullptr);
  const std::function<void()> give_up = [] { FAIL(); };
  const StepWatch::Span span(watch, give_up);
  EXPECT_FALSE(watch.stop());
}

}  // namespace
}  // namespace deform
