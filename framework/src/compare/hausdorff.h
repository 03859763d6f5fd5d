#pragma once

#include <vector>

#include "compare/triangles.h"

namespace deform {

/// The Hausdorff distance [m] of two surfaces that are given by triangles: the larger of the two
/// greatest distances from a node of one to the nearest point of the other.
///
/// `near_a` holds for every node of a the distance to some point of b, and `near_b` the reverse:
/// bounds that let most nodes be passed over. Their closeness decides the speed, not the result.
[[nodiscard]] double hausdorff_distance(const NodeVectors& a, const std::vector<Triangle>& faces_a,
                                        const NodeValues& near_a, const NodeVectors& b,
                                        const std::vector<Triangle>& faces_b,
                                        const NodeValues& near_b);

/// Squared distance [m²] of a point to a triangle.
[[nodiscard]] double squared_distance(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c);

}  // namespace deform
