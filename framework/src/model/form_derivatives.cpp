#include "model/form_derivatives.h"

#include <algorithm>

#include "deform/kernel.h"

namespace deform {
namespace {

/// out += factor x y.
DEFORM_KERNEL void add_product(Index size, double factor, const double* __restrict x,
                               const double* __restrict y, double* __restrict out) {
  for (Index s = 0; s < size; ++s) out[s] += factor * x[s] * y[s];
}

/// out += x (c y − a u) − v (b w): an entry of c n nᵀ − a n uᵀ − b v wᵀ.
DEFORM_KERNEL void add_entry(Index size, const double* __restrict x, const double* __restrict c,
                             const double* __restrict y, const double* __restrict a,
                             const double* __restrict u, const double* __restrict b,
                             const double* __restrict v, const double* __restrict w,
                             double* __restrict out) {
  for (Index s = 0; s < size; ++s)
    out[s] += x[s] * (c[s] * y[s] - a[s] * u[s]) - b[s] * v[s] * w[s];
}
DEFORM_KERNEL void add_entry(Index size, const double* __restrict x, const double* __restrict c,
                             const double* __restrict y, const double* __restrict a,
                             const double* __restrict u, double* __restrict out) {
  for (Index s = 0; s < size; ++s) out[s] += x[s] * (c[s] * y[s] - a[s] * u[s]);
}
DEFORM_KERNEL void add_entry(Index size, const double* __restrict x, const double* __restrict c,
                             const double* __restrict y, double* __restrict out) {
  for (Index s = 0; s < size; ++s) out[s] += x[s] * c[s] * y[s];
}

/// r^1 and r^2 (2 × 3): r^k = G^kl r_l.
using Dual = std::array<BlockTensor, 2>;
Dual dual_tangents(const GeometryBlock& g) {
  Dual dual{};
  for (int k = 0; k < 2; ++k)
    for (int l = 0; l < 2; ++l) {
      const double* reciprocal = g.reciprocal(kPairs[static_cast<std::size_t>(k + l)]).data();
      const ConstVectors r = g.r(first(l + 1));
      BlockTensor& out = dual[static_cast<std::size_t>(k)];
      add_product(g.size(), 1, reciprocal, r.x, out[0].data());
      add_product(g.size(), 1, reciprocal, r.y, out[1].data());
      add_product(g.size(), 1, reciprocal, r.z, out[2].data());
    }
  return dual;
}

Derivative derivative(int m) { return static_cast<Derivative>(m + 1); }

}  // namespace

void multiply(const FormStiffness& c, const BlockTensor& x, Index size, BlockTensor& out) {
  for (const Pair a : kPairs) {
    BlockValues& sum = out[static_cast<std::size_t>(slot(a))];
    std::fill_n(sum.begin(), size, 0.0);
    for (const Pair b : kPairs)
      add_product(size, 1, c.values(a, b), x[static_cast<std::size_t>(slot(b))].data(), sum.data());
  }
}

void CurvatureRows::quadratic(const FormStiffness& c, int m, int k, BlockValues& out) const {
  const Index size = geometry_.size();
  if (m >= 2) {
    std::copy_n(
        c.values(kPairs[static_cast<std::size_t>(m - 2)], kPairs[static_cast<std::size_t>(k - 2)]),
        size, out.begin());
    return;
  }
  std::fill_n(out.begin(), size, 0.0);
  for (int a = 0; a < 3; ++a) {
    const Pair row = kPairs[static_cast<std::size_t>(a)];
    if (k >= 2) {
      add_product(size, -1, gamma(m, a), c.values(row, kPairs[static_cast<std::size_t>(k - 2)]),
                  out.data());
      continue;
    }
    BlockValues sum{};  // Σ_b C_ab Γ^k_b
    for (int b = 0; b < 3; ++b)
      add_product(size, 1, c.values(row, kPairs[static_cast<std::size_t>(b)]), gamma(k, b),
                  sum.data());
    add_product(size, 1, gamma(m, a), sum.data(), out.data());
  }
}

void CurvatureRows::combined(const BlockTensor& M, int m, BlockValues& out) const {
  const Index size = geometry_.size();
  if (m >= 2) {
    std::copy_n(M[static_cast<std::size_t>(m - 2)].begin(), size, out.begin());
    return;
  }
  std::fill_n(out.begin(), size, 0.0);
  for (int a = 0; a < 3; ++a)
    add_product(size, -1, gamma(m, a), M[static_cast<std::size_t>(a)].data(), out.data());
}

void add_curvature_tangent(const GeometryBlock& geometry, const FormStiffness& c,
                           const BlockTensor* M, const JetTangent& h) {
  const Index size = geometry.size();
  const CurvatureRows L(geometry);
  const ConstVectors normal = geometry.n();
  const std::array<const double*, 3> n{normal.x, normal.y, normal.z};
  Dual dual;
  std::array<BlockValues, kJet> lambda;  // Σ_a M_a L_am
  BlockValues minus_MB{};                // −Σ_a M_a B_a
  if (M != nullptr) {
    dual = dual_tangents(geometry);
    for (int m = 0; m < kJet; ++m) L.combined(*M, m, lambda[static_cast<std::size_t>(m)]);
    for (const Pair a : kPairs)
      add_product(size, -1, (*M)[static_cast<std::size_t>(slot(a))].data(), geometry.B(a).data(),
                  minus_MB.data());
  }
  BlockValues along_nn;
  for (int m = 0; m < kJet; ++m)
    for (int k = m; k < kJet; ++k) {
      L.quadratic(c, m, k, along_nn);
      const bool both = M != nullptr && k < 2, one = M != nullptr && m < 2 && k >= 2;
      if (both)
        add_product(size, 1, minus_MB.data(),
                    geometry.reciprocal(kPairs[static_cast<std::size_t>(m + k)]).data(),
                    along_nn.data());
      const auto at_m = static_cast<std::size_t>(m), at_k = static_cast<std::size_t>(k);
      for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t j = 0; j < 3; ++j) {
          double* const out =
              h.entry(derivative(m), derivative(k), static_cast<int>(i), static_cast<int>(j));
          if (both)
            add_entry(size, n[i], along_nn.data(), n[j], lambda[at_k].data(), dual[at_m][j].data(),
                      lambda[at_m].data(), dual[at_k][i].data(), n[j], out);
          else if (one)
            add_entry(size, n[i], along_nn.data(), n[j], lambda[at_k].data(), dual[at_m][j].data(),
                      out);
          else
            add_entry(size, n[i], along_nn.data(), n[j], out);
        }
    }
}

}  // namespace deform
