/// The plane that lies nearest to a set of points.
#pragma once

#include "deform/export.h"
#include "deform/types.h"

namespace deform {

/// A plane with two perpendicular axes in it. For a plane parallel to xy the axes are x and y, up
/// to sign and order; in general the first axis is the projection onto the plane of x or y,
/// whichever lies nearer to it.
struct BestFitPlane {
  Vec3 centre = Vec3::Zero();        ///< centroid of the points [m]
  Vec3 normal = Vec3::UnitZ();       ///< unit vector; its largest component is positive
  Eigen::Matrix<double, 3, 2> axes;  ///< unit vectors in the plane, one a column
  double rms_distance = 0;           ///< root mean square distance of the points [m]
};

/// Least squares in the distance to the plane; `points` (N × 3) [m], N > 0, all weigh the same.
[[nodiscard]] DEFORM_API BestFitPlane best_fit_plane(const NodeVectors& points);

}  // namespace deform
