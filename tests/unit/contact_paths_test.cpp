/// Where straight paths come into bodies: known points, thin bodies, bodies that are not convex.
#include "solve/contact/contact_paths.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "deform/model/collider.h"

namespace deform {
namespace {

template <class F>
PathBody body_of(bool is_convex, const F& f) {
  return {[f](const NodeVectors& points, NodeValues& gap, NodeVectors& normal) {
            gap.resize(points.rows());
            normal.resize(points.rows(), 3);
            for (Index i = 0; i < points.rows(); ++i) {
              const SignedDistance d = f(Vec3(points.row(i).transpose()));
              gap[i] = d.distance;
              normal.row(i) = d.normal.transpose();
            }
          },
          is_convex};
}

SignedDistance ball(const Vec3& p, const Vec3& centre, double radius) {
  const Vec3 d = p - centre;
  return {d.norm() - radius, d.norm() > 0 ? Vec3(d.normalized()) : Vec3(Vec3::UnitZ())};
}

/// A ring about z: not convex.
SignedDistance ring(const Vec3& p) {
  const Vec3 across(p.x(), p.y(), 0);
  const Vec3 core = across.norm() > 0 ? Vec3(across.normalized()) : Vec3(Vec3::UnitX());
  return ball(p, core, 0.1);
}

std::vector<EntryPlane> entries(const PathBody& body, const Vec3& from, const Vec3& to) {
  return first_entries(body, NodeVectors(from.transpose()), NodeVectors(to.transpose()));
}

TEST(ContactPaths, EnterAConvexBodyAtTheFirstPointOfIt) {
  const auto unit = [](const Vec3& p) { return ball(p, Vec3::Zero(), 1); };
  std::mt19937 random(7);
  std::uniform_real_distribution<double> anywhere(-3, 3);
  int entered = 0;
  for (int trial = 0; trial < 500; ++trial) {
    const Vec3 from(anywhere(random), anywhere(random), anywhere(random));
    const Vec3 to(anywhere(random), anywhere(random), anywhere(random));
    if (from.norm() < 1) continue;
    const Vec3 way = to - from;
    const double half = from.dot(way), square = way.squaredNorm();
    const double inside = half * half - square * (from.squaredNorm() - 1);
    const double at = inside > 0 ? (-half - std::sqrt(inside)) / square : -1;
    for (const bool is_known_convex : {true, false}) {
      const auto found = entries(body_of(is_known_convex, unit), from, to);
      if (std::abs(inside) < 1e-2 || std::abs(at - 1) < 1e-2) continue;  // it grazes
      ASSERT_EQ(found.size(), at > 0 && at < 1 ? 1U : 0U) << trial;
      if (found.empty()) continue;
      ++entered;
      const Vec3 point = from + at * way;
      EXPECT_NEAR((found[0].normal - point).norm(), 0, 1e-6) << trial;
      EXPECT_NEAR(found[0].gap(point), 0, 1e-8) << trial;
    }
  }
  EXPECT_GT(entered, 50);
}

TEST(ContactPaths, EnterWhatIsThinnerThanTheWay) {
  for (const double half : {0.5, 1e-3, 1e-6})
    for (const bool is_known_convex : {true, false}) {
      const PathBody plate = body_of(is_known_convex, [half](const Vec3& p) {
        SignedDistance d;
        d.distance = rounded_box_distance<Vec3>(p, Vec3(9, 9, half), 0, d.normal);
        return d;
      });
      const auto found = entries(plate, {0.3, 0, 7}, {0, 0.2, -5});
      ASSERT_EQ(found.size(), 1U) << half;
      EXPECT_TRUE(found[0].normal.isApprox(Vec3::UnitZ(), 1e-12)) << half;
      EXPECT_NEAR(found[0].offset, half, 1e-9) << half;
      // From where it lies, down through the plate; but not up from it.
      EXPECT_EQ(entries(plate, {0, 0, half}, {0, 0, -5}).size(), 1U) << half;
      EXPECT_TRUE(entries(plate, {0, 0, half}, {0, 0, 5}).empty()) << half;
      EXPECT_TRUE(entries(plate, {9.001, 0, 5}, {9.001, 0, -5}).empty()) << half;
    }
}

TEST(ContactPaths, OfABodyThatIsNotConvexMayLeadThroughItsHole) {
  const PathBody body = body_of(false, ring);
  EXPECT_TRUE(entries(body, {0, 0, 3}, {0, 0, -3}).empty());
  EXPECT_TRUE(entries(body, {0.85, 0, 3}, {0.85, 0, -3}).empty());
  const auto found = entries(body, {1, 0, 3}, {1, 0, -3});
  ASSERT_EQ(found.size(), 1U);
  EXPECT_NEAR(found[0].offset, 0.1, 1e-8);
  // From the hole outwards.
  const auto outwards = entries(body, {0, 0, 0}, {3, 0, 0});
  ASSERT_EQ(outwards.size(), 1U);
  EXPECT_NEAR(outwards[0].offset, -0.9, 1e-8);
}

/// Whatever a body says, the search ends.
TEST(ContactPaths, EndInAbsurdWorlds) {
  const auto far = [](const Vec3& p) { return ball(p, Vec3(0, 0, -1e150), 1); };
  for (const bool is_convex : {true, false}) {
    EXPECT_TRUE(entries(body_of(is_convex, far), {0, 0, 0}, {0, 0, -1}).empty());
    // Distances that do not change along the way.
    EXPECT_LE(entries(body_of(is_convex,
                              [](const Vec3&) {
                                return SignedDistance{1e-20, -Vec3::UnitZ()};
                              }),
                      {0, 0, 0}, {0, 0, -1})
                  .size(),
              1U);
    EXPECT_LE(entries(body_of(is_convex,
                              [](const Vec3&) {
                                return SignedDistance{1e-3, Vec3::UnitZ()};
                              }),
                      {0, 0, 0}, {0, 0, -1})
                  .size(),
              1U);
  }
}

}  // namespace
}  // namespace deform
