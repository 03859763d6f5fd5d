#include "model/form_kernels.h"

#include "deform/kernel.h"

// Arrays do not overlap, those that are written and those that are read: what the pragmas below
// tell the compiler.
#define DEFORM_SAMPLES _Pragma("GCC ivdep")

namespace deform {

DEFORM_KERNEL void multiply_tensor(Index size, const Symmetric& C, const Components& x,
                                   const std::array<double*, 3>& M) {
  const double *x_11 = x[0], *x_12 = x[1], *x_22 = x[2];
  const double *c_0 = C[0], *c_1 = C[1], *c_2 = C[2], *c_3 = C[3], *c_4 = C[4], *c_5 = C[5];
  double *M_11 = M[0], *M_12 = M[1], *M_22 = M[2];
  DEFORM_SAMPLES
  for (Index s = 0; s < size; ++s) {
    M_11[s] = c_0[s] * x_11[s] + c_1[s] * x_12[s] + c_2[s] * x_22[s];
    M_12[s] = c_1[s] * x_11[s] + c_3[s] * x_12[s] + c_4[s] * x_22[s];
    M_22[s] = c_2[s] * x_11[s] + c_4[s] * x_12[s] + c_5[s] * x_22[s];
  }
}

DEFORM_KERNEL void negated_product(Index size, const Components& X, const Components& M,
                                   double* out) {
  const double *X_11 = X[0], *X_12 = X[1], *X_22 = X[2];
  const double *M_11 = M[0], *M_12 = M[1], *M_22 = M[2];
  DEFORM_SAMPLES
  for (Index s = 0; s < size; ++s)
    out[s] = -(X_11[s] * M_11[s] + X_12[s] * M_12[s] + X_22[s] * M_22[s]);
}

void multiply_gamma(Index size, const Components& gamma, const Symmetric& C,
                    const std::array<double*, 3>& out) {
  negated_product(size, gamma, {C[0], C[1], C[2]}, out[0]);
  negated_product(size, gamma, {C[1], C[3], C[4]}, out[1]);
  negated_product(size, gamma, {C[2], C[4], C[5]}, out[2]);
}

DEFORM_KERNEL void find_dual(Index size, const std::array<const double*, 2>& reciprocal,
                             const Components& r_1, const Components& r_2,
                             const std::array<double*, 3>& dual) {
  const double *g_1 = reciprocal[0], *g_2 = reciprocal[1];
  const double *x_1 = r_1[0], *y_1 = r_1[1], *z_1 = r_1[2];
  const double *x_2 = r_2[0], *y_2 = r_2[1], *z_2 = r_2[2];
  double *x = dual[0], *y = dual[1], *z = dual[2];
  DEFORM_SAMPLES
  for (Index s = 0; s < size; ++s) {
    x[s] = g_1[s] * x_1[s] + g_2[s] * x_2[s];
    y[s] = g_1[s] * y_1[s] + g_2[s] * y_2[s];
    z[s] = g_1[s] * z_1[s] + g_2[s] * z_2[s];
  }
}

DEFORM_KERNEL void add_along(Index size, const double* a, const Components& u,
                             const std::array<double*, 3>& sigma) {
  const double *u_x = u[0], *u_y = u[1], *u_z = u[2];
  double *x = sigma[0], *y = sigma[1], *z = sigma[2];
  DEFORM_SAMPLES
  for (Index s = 0; s < size; ++s) {
    x[s] += a[s] * u_x[s];
    y[s] += a[s] * u_y[s];
    z[s] += a[s] * u_z[s];
  }
}

DEFORM_KERNEL void add_twice_and_once(Index size, const double* a, const Components& u,
                                      const double* b, const Components& v,
                                      const std::array<double*, 3>& sigma) {
  const double *u_x = u[0], *u_y = u[1], *u_z = u[2];
  const double *v_x = v[0], *v_y = v[1], *v_z = v[2];
  double *x = sigma[0], *y = sigma[1], *z = sigma[2];
  DEFORM_SAMPLES
  for (Index s = 0; s < size; ++s) {
    const double twice = 2 * a[s], once = b[s];
    x[s] += twice * u_x[s] + once * v_x[s];
    y[s] += twice * u_y[s] + once * v_y[s];
    z[s] += twice * u_z[s] + once * v_z[s];
  }
}

DEFORM_KERNEL void add_curvature_stress(Index size, const CurvatureJet& of,
                                        const std::array<std::array<double*, 3>, 5>& to) {
  const CurvatureJet at = of;
  const std::array<std::array<double*, 3>, 5> sigma = to;
  DEFORM_SAMPLES
  for (Index s = 0; s < size; ++s) {
    const double g_1[3]{at.gamma[0][0][s], at.gamma[0][1][s], at.gamma[0][2][s]};
    const double g_2[3]{at.gamma[1][0][s], at.gamma[1][1][s], at.gamma[1][2][s]};
    for (std::size_t c = 0; c < 3; ++c) {
      const double r_1 = at.r[0][c][s], r_2 = at.r[1][c][s], n = at.n[c][s];
      double change[3];
      for (std::size_t b = 0; b < 3; ++b)
        change[b] = at.r[b + 2][c][s] - g_1[b] * r_1 - g_2[b] * r_2 - at.B_origin[b][s] * n;
      const double M_11 = at.C[0][s] * change[0] + at.C[1][s] * change[1] + at.C[2][s] * change[2];
      const double M_12 = at.C[1][s] * change[0] + at.C[3][s] * change[1] + at.C[4][s] * change[2];
      const double M_22 = at.C[2][s] * change[0] + at.C[4][s] * change[1] + at.C[5][s] * change[2];
      sigma[0][c][s] -= g_1[0] * M_11 + g_1[1] * M_12 + g_1[2] * M_22;
      sigma[1][c][s] -= g_2[0] * M_11 + g_2[1] * M_12 + g_2[2] * M_22;
      sigma[2][c][s] += M_11;
      sigma[3][c][s] += M_12;
      sigma[4][c][s] += M_22;
    }
  }
}

namespace {

/// out_ij += entry(i, j) at one sample.
template <class Entry>
[[gnu::always_inline]] inline void add_entries(const EntriesOut& out, Index s, const Entry& entry) {
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) out.data[(3 * i + j) * out.stride + s] += entry(i, j);
}

}  // namespace

DEFORM_KERNEL void add_block(Index size, const MetricBlock& of, const EntriesOut& to) {
  const MetricBlock b = of;
  const EntriesOut out = to;
  const bool has_K = b.K != nullptr;
  const double* const K = has_K ? b.K : b.C[0];  // some numbers that can be read
  DEFORM_SAMPLES
  for (Index s = 0; s < size; ++s) {
    const double C_11 = b.C[0][s], C_12 = b.C[1][s], C_21 = b.C[2][s], C_22 = b.C[3][s];
    const double k = has_K ? K[s] : 0;
    double left_1[3], left_2[3], right_1[3], right_2[3];
    for (std::size_t i = 0; i < 3; ++i) {
      const double r_1 = b.r_1[i][s], r_2 = b.r_2[i][s];
      left_1[i] = b.m[0] * r_1 * C_11 + b.m[1] * r_2 * C_21;
      left_2[i] = b.m[0] * r_1 * C_12 + b.m[1] * r_2 * C_22;
      right_1[i] = b.n[0] * r_1;
      right_2[i] = b.n[1] * r_2;
    }
    add_entries(out, s, [&](int i, int j) {
      const double sum = left_1[i] * right_1[j] + left_2[i] * right_2[j];
      return i == j ? sum + k : sum;
    });
  }
}

DEFORM_KERNEL void add_numbers(Index size, const double* x, double* to) {
  DEFORM_SAMPLES
  for (Index s = 0; s < size; ++s) to[s] += x[s];
}

DEFORM_KERNEL void add_normal_block(Index size, const double* c, const Components& n,
                                    const EntriesOut& to) {
  const EntriesOut out = to;
  const Components at = n;
  DEFORM_SAMPLES
  for (Index s = 0; s < size; ++s) {
    const double x[3]{at[0][s], at[1][s], at[2][s]};
    add_entries(out, s, [&](int i, int j) { return x[i] * c[s] * x[j]; });
  }
}

DEFORM_KERNEL void add_block(Index size, const MixedBlock& of, const EntriesOut& to) {
  const EntriesOut out = to;
  const MixedBlock b = of;
  DEFORM_SAMPLES
  for (Index s = 0; s < size; ++s) {
    const double n[3]{b.n[0][s], b.n[1][s], b.n[2][s]};
    double right[3];
    for (std::size_t j = 0; j < 3; ++j) right[j] = b.c[s] * n[j] - b.lambda[s] * b.u[j][s];
    add_entries(out, s, [&](int i, int j) { return n[i] * right[j]; });
  }
}

DEFORM_KERNEL void add_block(Index size, const TangentialBlock& of, const EntriesOut& to) {
  const EntriesOut out = to;
  const TangentialBlock b = of;
  const MixedBlock m = of.mixed;
  DEFORM_SAMPLES
  for (Index s = 0; s < size; ++s) {
    const double n[3]{m.n[0][s], m.n[1][s], m.n[2][s]};
    const double c = m.c[s] + b.b[s] * b.g[s];
    double right[3], left[3];
    for (std::size_t j = 0; j < 3; ++j) {
      right[j] = c * n[j] - m.lambda[s] * m.u[j][s];
      left[j] = b.mu[s] * b.v[j][s];
    }
    add_entries(out, s, [&](int i, int j) { return n[i] * right[j] - left[i] * n[j]; });
  }
}

}  // namespace deform
