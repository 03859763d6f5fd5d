/// Rigid paths of colliders.
#include "model/moving_collider.h"

#include <cmath>
#include <limits>
#include <memory>
#include <numbers>

#include <gtest/gtest.h>

#include "model/mirrored_parts.h"

namespace deform {
namespace {

constexpr double kPi = std::numbers::pi;

/// A ball of radius .5 about (1, 0, 0).
class Ball final : public Collider {
 public:
  void measure(double /*time*/, ConstVectors points, Values distance,
               Vectors normal) const override {
    measure_each(points, distance, normal, [](const Vec3& p) {
      const Vec3 d = p - Vec3::UnitX();
      return SignedDistance{d.norm() - 0.5, d.normalized()};
    });
  }
};

SignedDistance measured(const Collider& collider, double time, Vec3 p) {
  SignedDistance result;
  collider.measure(time, {&p[0], &p[1], &p[2]}, {&result.distance, 1},
                   {&result.normal[0], &result.normal[1], &result.normal[2]});
  return result;
}

Vec3 carried(const Collider& collider, double from, double to, Vec3 p) {
  Vec3 result;
  EXPECT_TRUE(
      collider.carry(from, to, 1, {&p[0], &p[1], &p[2]}, {&result[0], &result[1], &result[2]}));
  return result;
}

/// Half a turn about z through (0, 0, 0) within the first second, up by 2 in the next.
RigidPath path() {
  return {.times = {0, 1, 2},
          .displacements = {Vec3::Zero(), Vec3::Zero(), {0, 0, 2}},
          .rotations = {Vec3::Zero(), {0, 0, kPi}, {0, 0, kPi}}};
}

TEST(MovingCollider, IsWhereItsPathHasIt) {
  const auto ball = moving(std::make_shared<Ball>(), path());
  const double s = std::sqrt(0.5);
  for (const auto& [time, centre] : {std::pair(-1.0, Vec3(1, 0, 0)),
                                     {0.25, Vec3(s, s, 0)},
                                     {0.5, Vec3(0, 1, 0)},
                                     {1, Vec3(-1, 0, 0)},
                                     {1.5, Vec3(-1, 0, 1)},
                                     {9, Vec3(-1, 0, 2)}}) {
    const Vec3 beside = Vec3(0.3, -0.4, 1.2);
    const SignedDistance d = measured(*ball, time, centre + beside);
    EXPECT_NEAR(d.distance, 1.3 - 0.5, 1e-14) << time;
    EXPECT_LE((d.normal - beside / 1.3).norm(), 1e-14) << time;
  }
}

TEST(MovingCollider, CarriesItsPointsAlong) {
  const auto ball = moving(std::make_shared<Ball>(), path());
  const Vec3 point(1.2, 0.1, 0.3);
  EXPECT_LE((carried(*ball, 0, 0.5, point) - Vec3(-0.1, 1.2, 0.3)).norm(), 1e-14);
  EXPECT_LE((carried(*ball, 0.5, 2, {-0.1, 1.2, 0.3}) - Vec3(-1.2, -0.1, 2.3)).norm(), 1e-14);
  EXPECT_LE((carried(*ball, 1.7, 0, carried(*ball, 0, 1.7, point)) - point).norm(), 1e-14);
}

TEST(MovingCollider, TurnsAboutItsPivot) {
  RigidPath turn{.times = {0, 1}, .rotations = {Vec3::Zero(), {0, 0, kPi}}, .pivot = {2, 0, 0}};
  const auto ball = moving(std::make_shared<Ball>(), turn);
  EXPECT_NEAR(measured(*ball, 1, {3, 0, 0}).distance, -0.5, 1e-14);  // its middle
}

TEST(MovingCollider, WhatStaysCarriesNothing) {
  Vec3 p = Vec3::Zero();
  EXPECT_FALSE(Ball().carry(0, 1, 1, {&p[0], &p[1], &p[2]}, {&p[0], &p[1], &p[2]}));
}

TEST(MovingCollider, HasItsBreaksWhereThePathHasCorners) {
  const auto ball = moving(std::make_shared<Ball>(), path());
  EXPECT_EQ(ball->next_break(-1), 0);
  EXPECT_EQ(ball->next_break(0), 1);
  EXPECT_EQ(ball->next_break(2), std::numeric_limits<double>::infinity());
}

TEST(MovingCollider, ItsMirrorImageIsReflected) {
  const auto ball = moving(std::make_shared<Ball>(), path());
  const auto image = mirrored(ball);
  const Vec3 p(0.2, 0.7, 0.9);
  const Vec3 there = carried(*ball, 0.3, 1.6, p);
  EXPECT_EQ(carried(*image, 0.3, 1.6, {p.x(), p.y(), -p.z()}),
            Vec3(there.x(), there.y(), -there.z()));
}

TEST(MovingCollider, PathsThatDoNotFitAreNamed) {
  EXPECT_EQ(problem_of({}), "");
  EXPECT_EQ(problem_of(path()), "");
  EXPECT_EQ(problem_of({.times = {0}, .displacements = {}}),
            "'times' has neither 'displacements' nor 'rotations' to be the times of");
  EXPECT_EQ(problem_of({.times = {0, 1}, .displacements = {Vec3::Zero()}}),
            "'times' has 2 entries, 'displacements' 1: they must be as many");
  EXPECT_EQ(problem_of({.times = {0, 0}, .rotations = {Vec3::Zero(), Vec3::Zero()}}),
            "'times' must ascend, but 0 is followed by 0");
}

}  // namespace
}  // namespace deform
