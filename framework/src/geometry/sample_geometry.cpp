#include "geometry/sample_geometry.h"

#include <cmath>

#include "deform/kernel.h"

namespace deform {
namespace {

using Field = GeometryBlock;

/// Arrays of a block's fields, one number a sample.
struct Fields {
  double* data;
  Index stride;
  double* operator()(int field) const { return data + field * stride; }
};

DEFORM_KERNEL void normals(Index size, const double* __restrict jet, Index stride,
                           double* __restrict n) {
  const double *a = jet, *b = jet + 3 * stride;
  for (Index s = 0; s < size; ++s) {
    const double a0 = a[s], a1 = a[stride + s], a2 = a[2 * stride + s];
    const double b0 = b[s], b1 = b[stride + s], b2 = b[2 * stride + s];
    const double x = a1 * b2 - a2 * b1, y = a2 * b0 - a0 * b2, z = a0 * b1 - a1 * b0;
    const double length = std::sqrt(x * x + y * y + z * z);
    const bool is_regular = length > 0;
    const double divisor = is_regular ? length : 1.0;
    n[s] = is_regular ? x / divisor : 0.0;
    n[stride + s] = is_regular ? y / divisor : 0.0;
    n[2 * stride + s] = is_regular ? z / divisor : 0.0;
  }
}

/// out = a·b of vectors.
DEFORM_KERNEL void products(Index size, const double* __restrict a, const double* __restrict b,
                            Index stride, double* __restrict out) {
  for (Index s = 0; s < size; ++s)
    out[s] = a[s] * b[s] + a[stride + s] * b[stride + s] + a[2 * stride + s] * b[2 * stride + s];
}

/// A degenerate metric (a tangent that is not computable at the border, or a crushed cell) has no
/// reciprocal: all that needs it is 0, as the paper's section 4 ends.
DEFORM_KERNEL void reciprocals(Index size, const double* __restrict G, Index stride,
                               double* __restrict R, double* __restrict area) {
  for (Index s = 0; s < size; ++s) {
    const double G_11 = G[s], G_12 = G[stride + s], G_22 = G[2 * stride + s];
    const double det = G_11 * G_22 - G_12 * G_12;
    const bool is_regular = det > 0;
    const double positive = is_regular ? det : 1.0;
    const double inverse = is_regular ? 1 / positive : 0.0;
    area[s] = is_regular ? std::sqrt(positive) : 0.0;
    R[s] = G_22 * inverse;  // (13)
    R[stride + s] = -G_12 * inverse;
    R[2 * stride + s] = G_11 * inverse;
  }
}

/// Γ^1_ij and Γ^2_ij from R and r_ij·r_1, r_ij·r_2, which are where they go (15).
DEFORM_KERNEL void christoffel(Index size, const double* __restrict R, Index stride,
                               double* __restrict first, double* __restrict second) {
  for (Index s = 0; s < size; ++s) {
    const double along_1 = first[s], along_2 = second[s];
    first[s] = R[s] * along_1 + R[stride + s] * along_2;
    second[s] = R[stride + s] * along_1 + R[2 * stride + s] * along_2;
  }
}

/// d_ij (8).
DEFORM_KERNEL void weingarten(Index size, const double* __restrict G, const double* __restrict B,
                              Index stride, double* __restrict d) {
  for (Index s = 0; s < size; ++s) {
    const double G_11 = G[s], G_12 = G[stride + s], G_22 = G[2 * stride + s];
    const double B_11 = B[s], B_12 = B[stride + s], B_22 = B[2 * stride + s];
    const double det = G_11 * G_22 - G_12 * G_12;
    const bool is_regular = det > 0;
    const double positive = is_regular ? det : 1.0;
    const double inverse = is_regular ? 1 / positive : 0.0;
    d[s] = (B_12 * G_12 - B_11 * G_22) * inverse;
    d[stride + s] = (B_22 * G_12 - B_12 * G_22) * inverse;
    d[2 * stride + s] = (B_11 * G_12 - B_12 * G_11) * inverse;
    d[3 * stride + s] = (B_12 * G_12 - B_22 * G_11) * inverse;
  }
}

}  // namespace

Vec3 unit_normal(const Vec3& r_1, const Vec3& r_2) {
  const Vec3 cross = r_1.cross(r_2);
  const double length = cross.norm();
  return length > 0 ? Vec3(cross / length) : Vec3(Vec3::Zero());
}

void write_normals(double* data, Index stride, Index first, Index size) {
  const Fields at{data + first, stride};
  normals(size, at(0), stride, at(Field::kNormal));
}

void write_forms(double* data, Index stride, Index first, Index size) {
  const Fields at{data + first, stride};
  const double *r_1 = at(0), *r_2 = at(3), *n = at(Field::kNormal);
  products(size, r_1, r_1, stride, at(Field::kMetric));  // (3)
  products(size, r_1, r_2, stride, at(Field::kMetric + 1));
  products(size, r_2, r_2, stride, at(Field::kMetric + 2));
  reciprocals(size, at(Field::kMetric), stride, at(Field::kReciprocal), at(Field::kAreaElement));
  for (int ij = 0; ij < 3; ++ij) {
    const double* r_ij = at(6 + 3 * ij);
    products(size, n, r_ij, stride, at(Field::kCurvature + ij));  // (6)
    double *first_kind_1 = at(Field::kChristoffel + ij),
           *first_kind_2 = at(Field::kChristoffel + 3 + ij);
    products(size, r_ij, r_1, stride, first_kind_1);
    products(size, r_ij, r_2, stride, first_kind_2);
    christoffel(size, at(Field::kReciprocal), stride, first_kind_1, first_kind_2);
  }
  weingarten(size, at(Field::kMetric), at(Field::kCurvature), stride, at(Field::kWeingarten));
}

void write_sample(double* data, Index stride, Index s, const SampleGeometry& g) {
  const auto put = [&](int field, const Vec3& v) {
    for (int c = 0; c < 3; ++c) data[(field + c) * stride + s] = v[c];
  };
  for (int m = 0; m < 5; ++m) put(3 * m, g.jet[static_cast<std::size_t>(m)]);
  put(Field::kNormal, g.n);
  write_forms(data, stride, s, 1);
}

}  // namespace deform
