#include "deform/geometry/best_fit_plane.h"

#include <cmath>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

namespace deform {

BestFitPlane best_fit_plane(const NodeVectors& points) {
  BestFitPlane plane;
  plane.centre = points.colwise().mean();
  const NodeVectors centred = points.rowwise() - plane.centre.transpose();
  const Eigen::Matrix3d covariance = centred.transpose() * centred;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(covariance);
  plane.normal = solver.eigenvectors().col(0);  // of the smallest eigenvalue
  Index largest = 0;
  plane.normal.cwiseAbs().maxCoeff(&largest);
  if (plane.normal[largest] < 0) plane.normal = -plane.normal;

  const Vec3& n = plane.normal;
  const Vec3 towards = std::abs(n.x()) <= std::abs(n.y()) ? Vec3::UnitX() : Vec3::UnitY();
  plane.axes.col(0) = (towards - towards.dot(n) * n).normalized();
  plane.axes.col(1) = n.cross(Vec3(plane.axes.col(0)));
  // Not from the eigenvalue: its rounding error, relative to the largest, would show as 1e-8 in the
  // root.
  plane.rms_distance = std::sqrt((centred * n).squaredNorm() / static_cast<double>(points.rows()));
  return plane;
}

}  // namespace deform
