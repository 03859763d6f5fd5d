/// When a run that crawls is warned of: by what it gains, not by how fast this machine is.
#include "solve/stepping/headway.h"

#include <gtest/gtest.h>

namespace deform {
namespace {

/// A step of the scene in so many tries, the last after which `gained` [s] of its `length` are
/// done.
bool warns(Headway& headway, double length, long tries, double gained) {
  headway.begin(length);
  for (long i = 1; i <= tries; ++i)
    headway.tried(gained * static_cast<double>(i) / static_cast<double>(tries),
                  i % 2 == 0 ? "" : "it is picky");
  headway.end();
  return headway.has_warned();
}

// Any computer takes far more than 1e-15 hours for a hundred tries.
constexpr double kLongStep = 1e6, kNothing = 1e-15;

TEST(Headway, WarnsOfManyPartsThatGainNextToNothing) {
  Headway headway;
  EXPECT_FALSE(warns(headway, kLongStep, 99, kNothing));
  EXPECT_TRUE(warns(headway, kLongStep, 1000, kNothing));
  EXPECT_EQ(headway.tries(), 1000);
  EXPECT_EQ(headway.gained(), kNothing);
}

TEST(Headway, IsContentWithStepsThatTakeAsManyPartsAsOthers) {
  Headway headway;
  EXPECT_FALSE(warns(headway, kLongStep, 1000, kLongStep));
  EXPECT_FALSE(warns(headway, kLongStep, 3000, kNothing));
  EXPECT_TRUE(warns(headway, kLongStep, 4000, kNothing));
}

TEST(Headway, IsContentWithShortStepsInAnyUnitOfTime) {
  Headway headway;
  EXPECT_FALSE(warns(headway, 1e-9, 200, 1e-9));
}

}  // namespace
}  // namespace deform
