/// Colliders: distances to the surface of a body, with their gradient.
#include <algorithm>
#include <cmath>
#include <random>

#include <fmt/format.h>

#include "deform/model/collider.h"

#include "check/contracts.h"
#include "not_finite.h"

namespace deform {
namespace {

/// Of the difference quotients; not so small that rounding shows.
constexpr double kStep = 1e-6;

struct Measured {
  NodeValues distance;
  NodeVectors normal;
};

Measured measure(const Collider& collider, double time, const NodeVectors& points) {
  Measured m{NodeValues(points.rows()), NodeVectors(points.rows(), 3)};
  collider.measure(time, rows_from(points, 0),
                   {m.distance.data(), static_cast<std::size_t>(points.rows())},
                   rows_from(m.normal, 0));
  return m;
}

void check_distances(const Collider& collider, Checks& checks) {
  constexpr Index kPoints = kBlock;
  std::mt19937 random(5);
  std::uniform_real_distribution<double> anywhere(-2, 2);
  NodeVectors points(kPoints, 3);
  for (double& x : points.reshaped()) x = anywhere(random);
  const Measured m = measure(collider, 0.3, points);
  const Index bad = std::max(first_not_finite(m.distance), first_not_finite(m.normal));
  checks.holds("gives finite distances and normals", bad < 0,
               bad < 0
                   ? ""
                   : fmt::format("at ({:.3g}, {:.3g}, {:.3g}) the distance is {}, the normal "
                                 "({}, {}, {})",
                                 points(bad, 0), points(bad, 1), points(bad, 2), m.distance[bad],
                                 m.normal(bad, 0), m.normal(bad, 1), m.normal(bad, 2)));
  checks.below("normals have length 1", (m.normal.rowwise().norm().array() - 1).abs().maxCoeff(),
               1e-12);
  const Measured again = measure(collider, 0.3, points);
  checks.holds("depends on time and place alone",
               again.distance == m.distance && again.normal == m.normal, "it gave another answer");

  // No two points are farther apart by their distances than they are: a point that the distance
  // moves along the normal lands on the body's surface, from outside.
  double steepest = 0;
  for (Index i = 0; i + 1 < kPoints; ++i)
    steepest = std::max(steepest, std::abs(m.distance[i + 1] - m.distance[i]) /
                                      (points.row(i + 1) - points.row(i)).norm());
  checks.below("a distance changes by no more than the point moves", steepest, 1 + 1e-12);
  const NodeVectors landed = points - m.distance.asDiagonal() * m.normal;
  const NodeValues left = measure(collider, 0.3, landed).distance;
  double outside = 0;
  for (Index i = 0; i < kPoints; ++i)
    if (m.distance[i] > 0) outside = std::max(outside, std::abs(left[i]));
  checks.below("from outside, distance along the normal leads to the surface [m]", outside, 1e-9);

  if (collider.is_convex()) {
    double beyond = 0;  // how far a point's distance is below the tangent at the point before
    for (Index i = 0; i + 1 < kPoints; ++i)
      beyond =
          std::max(beyond, m.distance[i] + m.normal.row(i).dot(points.row(i + 1) - points.row(i)) -
                               m.distance[i + 1]);
    checks.below("is convex, as it says: no distance is below a tangent [m]", beyond, 1e-12);
  }

  NodeVectors gradient(kPoints, 3);
  for (int c = 0; c < 3; ++c) {
    NodeVectors ahead = points, behind = points;
    ahead.col(c).array() += kStep;
    behind.col(c).array() -= kStep;
    gradient.col(c) =
        (measure(collider, 0.3, ahead).distance - measure(collider, 0.3, behind).distance) /
        (2 * kStep);
  }
  // At a crease of the distance (in the middle of a body) there is no gradient: few points are so
  // near to one.
  const auto off = ((gradient - m.normal).rowwise().norm().array() > 1e-5).count();
  checks.below("share of points whose normal is not the gradient",
               static_cast<double>(off) / static_cast<double>(kPoints), 0.02);
}

/// What moves by itself takes its points there and back.
void check_carry(const Collider& collider, Checks& checks) {
  constexpr Index kPoints = 16;
  std::mt19937 random(6);
  std::uniform_real_distribution<double> anywhere(-2, 2);
  NodeVectors points(kPoints, 3), there = NodeVectors::Zero(kPoints, 3), back = there;
  for (double& x : points.reshaped()) x = anywhere(random);
  const auto carry = [&](double from, double to, const NodeVectors& of, NodeVectors& carried) {
    return collider.carry(from, to, kPoints, rows_from(of, 0), rows_from(carried, 0));
  };
  if (!carry(0.3, 0.7, points, there)) {
    checks.holds("leaves points alone where it does not move", there.isZero(0), "it has not");
    return;
  }
  checks.holds("carries points to finite places", there.allFinite(), "it does not");
  NodeVectors half = there, whole = there;
  checks.holds("carries them in two parts, too",
               carry(0.3, 0.5, points, half) && carry(0.5, 0.7, half, whole), "it does not");
  checks.below("and then to the same places [m]", (whole - there).cwiseAbs().maxCoeff(), 1e-9);
  checks.holds("carries them back, too", carry(0.7, 0.3, there, back), "it does not");
  checks.below("and leaves them where they were [m]", (back - points).cwiseAbs().maxCoeff(), 1e-9);
}

}  // namespace

void check_collider_contract(const Subject& subject, Checks& checks) {
  const Terrain terrain = terrains(9, 7).front();
  checks.at(terrain.name);
  checks.runs("measures distances",
              [&] { check_distances(*subject.make<Collider>(terrain).object, checks); });
  checks.runs("carries points",
              [&] { check_carry(*subject.make<Collider>(terrain).object, checks); });
  check_run(subject, checks);
}

}  // namespace deform
