#include "solve/stopwatch.h"

#include <thread>

#include <gtest/gtest.h>

namespace deform {
namespace {

using Seconds = std::chrono::duration<double>;

void pass(double seconds) { std::this_thread::sleep_for(Seconds(seconds)); }

TEST(Stopwatch, CountsEachMomentOnce) {
  double outer = 0, inner = 0;
  const auto begun = std::chrono::steady_clock::now();
  {
    const Stopwatch a(outer, "outer");
    pass(0.01);
    {
      const Stopwatch b(inner, "inner");
      pass(0.01);
      const Stopwatch again(outer, "outer");
      pass(0.01);
    }
  }
  const double whole = Seconds(std::chrono::steady_clock::now() - begun).count();
  EXPECT_GE(outer, 0.02);
  EXPECT_GE(inner, 0.01);
  EXPECT_LE(outer + inner, whole);
}

}  // namespace
}  // namespace deform
