#include "solve/contacts.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <fmt/format.h>

#include "deform/parallel.h"

#include "plugin/guard.h"
#include "solve/not_finite.h"

namespace deform {
namespace {

/// Out of one body a node may come into another one; in a corner of two it takes a few turns.
constexpr int kMostRounds = 8;

/// Reflection at z = 0.
NodeVectors reflected(NodeVectors v) {
  v.col(2) *= -1;
  return v;
}

}  // namespace

Contacts::Contacts(std::vector<Body> bodies, bool mirrored, const Reduction& reduction)
    : bodies_(std::move(bodies)), mirrored_(mirrored) {
  for (Index a = 0; a < reduction.nodes(); ++a)
    free_.push_back(!reduction.prescribed(a, 0) && !reduction.prescribed(a, 1) &&
                    !reduction.prescribed(a, 2));
}

void Contacts::measure(const Body& body, double time, const NodeVectors& points,
                       NodeValues& distance, NodeVectors& normal) const {
  const NodeVectors there = mirrored_ ? reflected(points) : NodeVectors();  // the scene's world
  const NodeVectors& p = mirrored_ ? there : points;
  distance.resize(p.rows());
  normal.resize(p.rows(), 3);
  parallel_blocks(p.rows(), kBlock, [&](Index first, Index size) {
    guarded(body.collider.origin, "measuring distances", [&] {
      body.collider.object->measure(time, rows_from(p, first),
                                    {distance.data() + first, static_cast<std::size_t>(size)},
                                    rows_from(normal, first));
    });
  });
  if (mirrored_) normal.col(2) *= -1;
  require_finite(distance, "a distance", body.collider.origin, body.collider.name);
  require_finite(normal, "a normal", body.collider.origin, body.collider.name);
}

void Contacts::resolve(const NodeVectors& before, double step, State& after) {
  for (int round = 0; round < kMostRounds; ++round) {
    bool any = false;
    for (const Body& body : bodies_) any = resolve(body, before, step, after) || any;
    if (!any || bodies_.size() == 1) return;
  }
}

bool Contacts::resolve(const Body& body, const NodeVectors& before, double step, State& after) {
  measure(body, after.time, after.r, distance_, normal_);
  bool any = false;
  for (Index a = 0; a < after.r.rows(); ++a) {
    const double depth = body.thickness - distance_[a];
    if (!(depth > 0) || free_[static_cast<std::size_t>(a)] == 0) continue;
    any = true;
    const Vec3 n = normal_.row(a).transpose();
    Vec3 moved = after.r.row(a).transpose() + depth * n - before.row(a).transpose();
    const Vec3 slid = moved - moved.dot(n) * n;
    const double length = slid.norm();
    if (length > 0) moved -= std::min(1.0, body.friction * depth / length) * slid;
    after.r.row(a) = before.row(a) + moved.transpose();
    after.v.row(a) = moved.transpose() / step;
  }
  return any;
}

void Contacts::find(double time, const NodeVectors& r, double within,
                    std::vector<NodeContact>& found) const {
  found.clear();
  NodeValues distance;
  NodeVectors normal;
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    const Body& body = bodies_[b];
    measure(body, time, r, distance, normal);
    for (Index a = 0; a < r.rows(); ++a) {
      const double gap = distance[a] - body.thickness;
      if (gap < within && free_[static_cast<std::size_t>(a)] != 0)
        found.push_back({a, b, gap, normal.row(a).transpose(), body.friction});
    }
  }
}

NodeValues Contacts::clearance(double time, const NodeVectors& points) const {
  NodeValues least = NodeValues::Constant(points.rows(), std::numeric_limits<double>::infinity());
  NodeValues distance;
  NodeVectors normal;
  for (const Body& body : bodies_) {
    measure(body, time, points, distance, normal);
    least = least.cwiseMin(distance);
  }
  return least;
}

void Contacts::require_outside(const NodeVectors& r, double slack) const {
  NodeValues distance;
  NodeVectors normal;
  std::vector<Problem> problems;
  for (const Body& body : bodies_) {
    try {
      measure(body, 0, r, distance, normal);
    } catch (const NotFinite& e) {
      problems.push_back({body.pointer, fmt::format("at {}: {} at first: no number holds squares "
                                                    "of such sizes",
                                                    body.pointer, e.what())});
      continue;
    }
    Index worst = -1;
    for (Index a = 0; a < r.rows(); ++a)
      if (free_[static_cast<std::size_t>(a)] != 0 && (worst < 0 || distance[a] < distance[worst]))
        worst = a;
    if (worst < 0 || body.thickness - distance[worst] <= slack) continue;
    problems.push_back(
        {body.pointer,
         fmt::format("at {}: node {} begins {:.3g} m inside of this collider (thickness included), "
                     "expected all nodes outside",
                     body.pointer, worst, body.thickness - distance[worst])});
  }
  if (!problems.empty()) throw InputError(std::move(problems));
}

}  // namespace deform
