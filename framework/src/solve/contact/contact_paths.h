/// Where nodes that move far within a step come into a body.
#pragma once

#include <functional>
#include <vector>

#include "deform/types.h"

namespace deform {

/// The half-space that a body fills beyond its tangent plane where a node came in.
struct EntryPlane {
  Index path = 0;
  Vec3 normal = Vec3::UnitZ();  ///< away from the body
  double offset = 0;            ///< [m]
  [[nodiscard]] double gap(const Vec3& x) const { return normal.dot(x) - offset; }
};

/// A body as paths see it: gaps [m] at points (M × 3), negative inside, and their gradients.
struct PathBody {
  std::function<void(const NodeVectors& points, NodeValues& gap, NodeVectors& normal)> measure;
  bool is_convex = false;
};

/// Of straight paths (M × 3 [m] each end), those that come into a body, by path, with the tangent
/// plane where they first do; what is inside at the start and moves inwards comes in there.
///
/// A gap grows by no more than the path, so a node may go as far as its gap before it looks again
/// (sphere tracing: Hart 1996; conservative advancement: Mirtich 1996). Where a body is convex, so
/// is its distance, and Newton's steps along the path never go beyond the first entry. Along the
/// surface of any other body no step is shorter than a part of the path, and what comes in on such
/// a step is found by bisection.
[[nodiscard]] std::vector<EntryPlane> first_entries(const PathBody& body, const NodeVectors& from,
                                                    const NodeVectors& to);

}  // namespace deform
