#include "solve/stopwatch.h"

#include <thread>

#include <gtest/gtest.h>

namespace deform {
namespace {

using Seconds = std::chrono::duration<double>;

void pass(double seconds) { std::this_thread::sleep_for(Seconds(seconds)); }

TEST(Stopwatch, CountsEachMomentOnce) {
  StepTimes times;
  const TimesAddedTo counted(&times);
  const auto begun = std::chrono::steady_clock::now();
  {
    const Stopwatch a(&StepTimes::assembly, "outer");
    pass(0.01);
    {
      const Stopwatch b(&StepTimes::solve, "inner");
      pass(0.01);
      const Stopwatch again(&StepTimes::assembly, "outer");
      pass(0.01);
    }
  }
  const double whole = Seconds(std::chrono::steady_clock::now() - begun).count();
  EXPECT_GE(times.assembly, 0.02);
  EXPECT_GE(times.solve, 0.01);
  EXPECT_LE(times.assembly + times.solve, whole);
}

TEST(Stopwatch, AddsToTheTimesThatWereNamedLast) {
  StepTimes model;
  const TimesAddedTo counted(&model);
  {
    const TimesAddedTo nobody(nullptr);
    const Stopwatch probe(&StepTimes::assembly, "of a probe");
    pass(0.001);
  }
  EXPECT_EQ(model.assembly, 0);
  { const Stopwatch step(&StepTimes::assembly, "of a step"); }
  EXPECT_GT(model.assembly, 0);
}

}  // namespace
}  // namespace deform
