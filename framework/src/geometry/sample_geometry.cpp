#include "geometry/sample_geometry.h"

#include <cmath>

#include "deform/kernel.h"

namespace deform {
namespace {

using Field = GeometryBlock;

/// Arrays of a block's fields, one number a sample. They do not overlap: what the pragmas below
/// tell the compiler.
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

/// Three numbers a sample, from array to array.
struct Triple {
  const double *x, *y, *z;
  Triple(const double* data, Index stride) : x(data), y(data + stride), z(data + 2 * stride) {}
};
[[gnu::always_inline]] inline double product(const Triple& a, const Triple& b, Index s) {
  return a.x[s] * b.x[s] + a.y[s] * b.y[s] + a.z[s] * b.z[s];
}

/// G (3), the reciprocal metric (13) and the area element. A degenerate metric (a tangent that is
/// not computable at the border, or a crushed cell) has no reciprocal: all that needs it is 0, as
/// the paper's section 4 ends.
DEFORM_KERNEL void metric(Index size, const double* jet, Index stride, double* G, double* R,
                          double* area) {
  const Triple r_1(jet, stride), r_2(jet + 3 * stride, stride);
  double *G_12 = G + stride, *G_22 = G + 2 * stride, *R_12 = R + stride, *R_22 = R + 2 * stride;
#pragma GCC ivdep
  for (Index s = 0; s < size; ++s) {
    const double g_11 = product(r_1, r_1, s), g_12 = product(r_1, r_2, s),
                 g_22 = product(r_2, r_2, s);
    G[s] = g_11, G_12[s] = g_12, G_22[s] = g_22;
    const double det = g_11 * g_22 - g_12 * g_12;
    const bool is_regular = det > 0;
    const double positive = is_regular ? det : 1.0;
    const double inverse = is_regular ? 1 / positive : 0.0;
    area[s] = is_regular ? std::sqrt(positive) : 0.0;
    R[s] = g_22 * inverse;  // (13)
    R_12[s] = -g_12 * inverse;
    R_22[s] = g_11 * inverse;
  }
}

/// G alone, with the bits that it has above.
DEFORM_KERNEL void metric_alone(Index size, const double* jet, Index stride, double* G) {
  const Triple r_1(jet, stride), r_2(jet + 3 * stride, stride);
  double *G_12 = G + stride, *G_22 = G + 2 * stride;
#pragma GCC ivdep
  for (Index s = 0; s < size; ++s) {
    G[s] = product(r_1, r_1, s);
    G_12[s] = product(r_1, r_2, s);
    G_22[s] = product(r_2, r_2, s);
  }
}

/// B_ij (6), Γ^1_ij and Γ^2_ij (15) of one pair ij.
DEFORM_KERNEL void curvature(Index size, const double* jet, const double* normal,
                             const double* second, const double* R, Index stride, double* B,
                             double* gamma_1, double* gamma_2) {
  const Triple r_1(jet, stride), r_2(jet + 3 * stride, stride), n(normal, stride),
      r_ij(second, stride), reciprocal(R, stride);
#pragma GCC ivdep
  for (Index s = 0; s < size; ++s) {
    B[s] = product(n, r_ij, s);
    const double along_1 = product(r_ij, r_1, s), along_2 = product(r_ij, r_2, s);
    gamma_1[s] = reciprocal.x[s] * along_1 + reciprocal.y[s] * along_2;
    gamma_2[s] = reciprocal.y[s] * along_1 + reciprocal.z[s] * along_2;
  }
}

/// Γ^1_ij and Γ^2_ij by r_ij = Γ^k_ij r_k + b_ij n with a normal n that is not quite normal to r_1
/// and r_2, where these are independent and n points to their side; else they stay.
DEFORM_KERNEL void christoffel_beside(Index size, const double* jet, const double* normal,
                                      const double* second, const double* R, Index stride,
                                      double* gamma_1, double* gamma_2) {
  const Triple r_1(jet, stride), r_2(jet + 3 * stride, stride), n(normal, stride),
      r_ij(second, stride), reciprocal(R, stride);
#pragma GCC ivdep
  for (Index s = 0; s < size; ++s) {
    const double x = r_1.y[s] * r_2.z[s] - r_1.z[s] * r_2.y[s],
                 y = r_1.z[s] * r_2.x[s] - r_1.x[s] * r_2.z[s],
                 z = r_1.x[s] * r_2.y[s] - r_1.y[s] * r_2.x[s];
    const double along = x * n.x[s] + y * n.y[s] + z * n.z[s];
    const bool is_regular = along > 0;
    const double b = (x * r_ij.x[s] + y * r_ij.y[s] + z * r_ij.z[s]) / (is_regular ? along : 1.0);
    const double along_1 = product(r_ij, r_1, s) - b * product(n, r_1, s),
                 along_2 = product(r_ij, r_2, s) - b * product(n, r_2, s);
    gamma_1[s] = is_regular ? reciprocal.x[s] * along_1 + reciprocal.y[s] * along_2 : gamma_1[s];
    gamma_2[s] = is_regular ? reciprocal.y[s] * along_1 + reciprocal.z[s] * along_2 : gamma_2[s];
  }
}

DEFORM_KERNEL void mean(Index size, const double* __restrict a, const double* __restrict b,
                        double* __restrict out) {
  for (Index s = 0; s < size; ++s) out[s] = 0.5 * (a[s] + b[s]);
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

void write_metric(double* data, Index stride, Index first, Index size) {
  const Fields at{data + first, stride};
  metric_alone(size, at(0), stride, at(Field::kMetric));
}

void write_metric_and_reciprocal(double* data, Index stride, Index first, Index size) {
  const Fields at{data + first, stride};
  metric(size, at(0), stride, at(Field::kMetric), at(Field::kReciprocal), at(Field::kAreaElement));
}

void write_curvature(double* data, Index stride, Index first, Index size) {
  const Fields at{data + first, stride};
  for (int ij = 0; ij < 3; ++ij)
    curvature(size, at(0), at(Field::kNormal), at(6 + 3 * ij), at(Field::kReciprocal), stride,
              at(Field::kCurvature + ij), at(Field::kChristoffel + ij),
              at(Field::kChristoffel + 3 + ij));
  weingarten(size, at(Field::kMetric), at(Field::kCurvature), stride, at(Field::kWeingarten));
}

namespace {

/// Three fields of numbers.
void write_means(const MeanOf& ends, int field, double* data, Index stride, Index first,
                 Index size) {
  for (int c = field; c < field + 3; ++c) {
    const Index at = c * stride + first;
    mean(size, ends.from + at, ends.to + at, data + at);
  }
}

}  // namespace

void write_mean_normals(const MeanOf& ends, double* data, Index stride, Index first, Index size) {
  write_means(ends, Field::kNormal, data, stride, first, size);
}

void write_mean_metric(const MeanOf& ends, double* data, Index stride, Index first, Index size) {
  write_means(ends, Field::kMetric, data, stride, first, size);
}

void write_mean_curvature(const MeanOf& ends, double* data, Index stride, Index first, Index size) {
  write_means(ends, Field::kCurvature, data, stride, first, size);
  const Fields at{data + first, stride};
  for (int ij = 0; ij < 3; ++ij)
    christoffel_beside(size, at(0), at(Field::kNormal), at(6 + 3 * ij), at(Field::kReciprocal),
                       stride, at(Field::kChristoffel + ij), at(Field::kChristoffel + 3 + ij));
  weingarten(size, at(Field::kMetric), at(Field::kCurvature), stride, at(Field::kWeingarten));
}

void write_sample(double* data, Index stride, Index s, const SampleGeometry& g) {
  const auto put = [&](int field, const Vec3& v) {
    for (int c = 0; c < 3; ++c) data[(field + c) * stride + s] = v[c];
  };
  for (int m = 0; m < 5; ++m) put(3 * m, g.jet[static_cast<std::size_t>(m)]);
  put(Field::kNormal, g.n);
  write_metric_and_reciprocal(data, stride, s, 1);
  write_curvature(data, stride, s, 1);
}

}  // namespace deform
