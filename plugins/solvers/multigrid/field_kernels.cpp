#include "field_kernels.h"

#include <deform/kernel.h>

#include "vectors.h"

namespace multigrid {
namespace {

template <int bytes>
[[gnu::always_inline]] inline Vector<double, bytes> doubles(const double* from) {
  return load<Vector<double, bytes>>(from);
}
template <int bytes>
[[gnu::always_inline]] inline Vector<double, bytes> doubles(const float* from) {
  return __builtin_convertvector((load<Vector<float, bytes / 2>>(from)), Vector<double, bytes>);
}

/// Sixteen sums of every sixteenth product, so that one does not wait for the other; added up in
/// the same order by vectors of any width.
template <int bytes, class Number>
[[gnu::always_inline]] inline double dot_by(Index size, const Number* a, const Number* b) {
  constexpr Index kSums = 16, lanes = kSize<Vector<double, bytes>>, vectors = kSums / lanes;
  Vector<double, bytes> sums[vectors]{};
  Index i = 0;
  for (; i + kSums <= size; i += kSums)
    for (Index v = 0; v < vectors; ++v)
      sums[v] += doubles<bytes>(a + i + v * lanes) * doubles<bytes>(b + i + v * lanes);
  double s[kSums];
  for (Index v = 0; v < vectors; ++v) store(sums[v], s + v * lanes);
  for (Index k = 0; k < kSums / 2; ++k) s[k] += s[k + kSums / 2];
  double sum = ((s[0] + s[4]) + (s[1] + s[5])) + ((s[2] + s[6]) + (s[3] + s[7]));
  for (; i < size; ++i) sum += static_cast<double>(a[i]) * static_cast<double>(b[i]);
  return sum;
}

}  // namespace

DEFORM_VECTOR_KERNEL(double, dot, (Index size, const float* a, const float* b), (size, a, b))
DEFORM_VECTOR_KERNEL(double, dot, (Index size, const double* a, const double* b), (size, a, b))

DEFORM_KERNEL void add(Index size, float factor, const float* from, float* to) {
#pragma GCC ivdep
  for (Index i = 0; i < size; ++i) to[i] += factor * from[i];
}
DEFORM_KERNEL void add(Index size, float factor, const float* from, double* to) {
#pragma GCC ivdep
  for (Index i = 0; i < size; ++i)
    to[i] += static_cast<double>(factor) * static_cast<double>(from[i]);
}
DEFORM_KERNEL void scale_and_add(Index size, float factor, const float* from, float* to) {
#pragma GCC ivdep
  for (Index i = 0; i < size; ++i) to[i] = from[i] + factor * to[i];
}
DEFORM_KERNEL void subtract_from(Index size, const float* f, float* r) {
#pragma GCC ivdep
  for (Index i = 0; i < size; ++i) r[i] = f[i] - r[i];
}
DEFORM_KERNEL void subtract_from(Index size, const double* f, const double* product, float* r) {
#pragma GCC ivdep
  for (Index i = 0; i < size; ++i) r[i] = static_cast<float>(f[i] - product[i]);
}

DEFORM_KERNEL void smooth_scalars(Index first, Index size, float omega, const Inverse& inverse,
                                  const Components<const float>& r, const Components<float>& x,
                                  bool adds) {
  const float* d = inverse.data + first;
  for (Index c = 0; c < 3; ++c) {
    const float* from = r.data + c * r.stride + first;
    float* to = x.data + c * x.stride + first;
#pragma GCC ivdep
    for (Index a = 0; a < size; ++a) to[a] = (adds ? to[a] : 0) + omega * (d[a] * from[a]);
  }
}

DEFORM_KERNEL void smooth_blocks(Index first, Index size, float omega, const Inverse& inverse,
                                 const Components<const float>& r, const Components<float>& x,
                                 bool adds) {
  const Index s = inverse.stride;
  const float *d = inverse.data + first, *f = r.data + first;
  const float *d_01 = d + s, *d_02 = d + 2 * s, *d_11 = d + 3 * s, *d_12 = d + 4 * s,
              *d_22 = d + 5 * s, *f_1 = f + r.stride, *f_2 = f + 2 * r.stride;
  float *x_0 = x.data + first, *x_1 = x_0 + x.stride, *x_2 = x_1 + x.stride;
#pragma GCC ivdep
  for (Index a = 0; a < size; ++a) {
    const float u = f[a], v = f_1[a], w = f_2[a];
    x_0[a] = (adds ? x_0[a] : 0) + omega * (d[a] * u + d_01[a] * v + d_02[a] * w);
    x_1[a] = (adds ? x_1[a] : 0) + omega * (d_01[a] * u + d_11[a] * v + d_12[a] * w);
    x_2[a] = (adds ? x_2[a] : 0) + omega * (d_02[a] * u + d_12[a] * v + d_22[a] * w);
  }
}

DEFORM_KERNEL void invert_scalars(Index size, const float* diagonal, float* inverse) {
#pragma GCC ivdep
  for (Index a = 0; a < size; ++a) {
    const bool is_resisted = diagonal[a] > 0;
    inverse[a] = is_resisted ? 1 / (is_resisted ? diagonal[a] : 1.0F) : 1.0F;
  }
}

/// By cofactors, in double precision: stretching may resist a thousand times as much as bending.
DEFORM_KERNEL void invert_blocks(Index size, const float* diagonal, Index lanes, float* inverse,
                                 Index stride) {
  const float *xx = diagonal, *xy = xx + lanes, *xz = xy + lanes, *yy = xx + 4 * lanes,
              *yz = yy + lanes, *zz = xx + 8 * lanes;
  float *i_xx = inverse, *i_xy = i_xx + stride, *i_xz = i_xy + stride, *i_yy = i_xz + stride,
        *i_yz = i_yy + stride, *i_zz = i_yz + stride;
#pragma GCC ivdep
  for (Index a = 0; a < size; ++a) {
    const auto x = static_cast<double>(xx[a]), y = static_cast<double>(yy[a]),
               z = static_cast<double>(zz[a]);
    const bool has_x = x > 0, has_y = y > 0, has_z = z > 0;
    const double m_00 = has_x ? x : 1, m_11 = has_y ? y : 1, m_22 = has_z ? z : 1;
    const double m_01 = has_x && has_y ? static_cast<double>(xy[a]) : 0,
                 m_02 = has_x && has_z ? static_cast<double>(xz[a]) : 0,
                 m_12 = has_y && has_z ? static_cast<double>(yz[a]) : 0;
    const double c_00 = m_11 * m_22 - m_12 * m_12, c_01 = m_02 * m_12 - m_01 * m_22,
                 c_02 = m_01 * m_12 - m_02 * m_11;
    const double det = m_00 * c_00 + m_01 * c_01 + m_02 * c_02;
    const double over = 1 / det;
    i_xx[a] = static_cast<float>(c_00 * over);
    i_xy[a] = static_cast<float>(c_01 * over);
    i_xz[a] = static_cast<float>(c_02 * over);
    i_yy[a] = static_cast<float>((m_00 * m_22 - m_02 * m_02) * over);
    i_yz[a] = static_cast<float>((m_01 * m_02 - m_00 * m_12) * over);
    i_zz[a] = static_cast<float>((m_00 * m_11 - m_01 * m_01) * over);
  }
}

}  // namespace multigrid
