/// Geometry of samples from their jets; the one place where (3), (6), (8), (13) and (15) stand.
#pragma once

#include <array>

#include "deform/geometry/geometry.h"

namespace deform {

/// One sample's jet and normal.
struct SampleGeometry {
  std::array<Vec3, 5> jet;  ///< r_1, r_2, r_11, r_12, r_22
  Vec3 n = Vec3::Zero();
};

/// r_1×r_2/|r_1×r_2| (6), zero where the tangents are parallel.
[[nodiscard]] Vec3 unit_normal(const Vec3& r_1, const Vec3& r_2);

/// All of these are for samples first … first+size−1 of storage of GeometryBlock's layout: n from
/// r_1 and r_2, which are there; G alone; what else follows from these; what follows from the whole
/// jet, n and that; and all fields of one sample.
void write_normals(double* data, Index stride, Index first, Index size);
void write_metric(double* data, Index stride, Index first, Index size);
void write_metric_and_reciprocal(double* data, Index stride, Index first, Index size);
void write_curvature(double* data, Index stride, Index first, Index size);

/// Storage of the geometries of two states, whose mean is taken.
struct MeanOf {
  const double *from, *to;
};
/// Geometry::make_mean, over what is there of the state in the middle, in this order: G; n, where
/// it is known; B, Γ and d, where second derivatives are.
void write_mean_metric(const MeanOf& ends, double* data, Index stride, Index first, Index size);
void write_mean_normals(const MeanOf& ends, double* data, Index stride, Index first, Index size);
void write_mean_curvature(const MeanOf& ends, double* data, Index stride, Index first, Index size);
void write_sample(double* data, Index stride, Index s, const SampleGeometry& g);

}  // namespace deform
