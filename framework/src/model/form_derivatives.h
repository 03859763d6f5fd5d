/// First and second derivatives of G and B with respect to the jet, for a block of samples at once:
/// stress and tangents of energies that are quadratic in their changes.
#pragma once

#include <array>

#include "deform/geometry/geometry.h"
#include "deform/model/energy_term.h"
#include "deform/model/quadratic_term.h"
#include "deform/model/tangent.h"

#include "model/form_kernels.h"

namespace deform {

/// Numbers of the samples of a block.
using BlockValues = std::array<double, kBlock>;
/// T_11, T_12, T_22 at each of them.
using BlockTensor = std::array<BlockValues, 3>;

/// C x for a tensor x.
void multiply(const FormStiffness& C, const BlockTensor& x, Index size, BlockTensor& out);

/// σ_m += Σ_a S_a ∂G_a/∂r_m.
void add_metric_stress(const GeometryBlock& geometry, const BlockTensor& S, const Stress& sigma);
/// h_mn += Σ_ab (∂G_a/∂r_m) C_ab (∂G_b/∂r_n)ᵀ + K_mn I; K: (11, 12, 22), 0 where it is null.
void add_metric_tangent(const GeometryBlock& geometry, const FormStiffness& C, const BlockTensor* K,
                        const JetTangent& h);

/// δB_a = n · Σ_m L_am δ(D_m r): the rows of L_ij = D_ij − Γ^k_ij D_k, a = 11, 12, 22, over the
/// jet's five derivatives: L_am is 1 where D_m is D_a, −Γ^m_a for m = 1, 2, else 0.
///
/// λ_m = Σ_a L_am M_a, m counted from 0. M must live as long.
class CurvatureStress {
 public:
  CurvatureStress(const GeometryBlock& geometry, const BlockTensor& M);
  [[nodiscard]] const double* operator()(int m) const {
    return lambda_[static_cast<std::size_t>(m)];
  }

 private:
  std::array<BlockValues, 2> tangential_;
  std::array<const double*, kJet> lambda_{};
};

/// c_mk = Σ_ab L_am C_ab L_bk, m ≤ k counted from 0. C must live as long.
class CurvatureStiffness {
 public:
  CurvatureStiffness(const GeometryBlock& geometry, const FormStiffness& C);
  [[nodiscard]] const double* operator()(int m, int k) const {
    return c_[static_cast<std::size_t>(m)][static_cast<std::size_t>(k)];
  }

 private:
  std::array<BlockTensor, 2> mixed_;  // m = 1, 2 with 11, 12, 22
  BlockTensor tangential_;            // 11, 12, 22
  std::array<std::array<const double*, kJet>, kJet> c_{};
};

/// σ_m += Σ_a L_am M_a n.
void add_normal_stress(const GeometryBlock& geometry, const BlockTensor& M, const Stress& sigma);
/// σ_m += Σ_ab L_am C_ab (L_b r − B⁰_b n), B⁰ being that of the origin. L_b r is B_b n, and this
/// Σ_a L_am M_a n, where n is normal to r_1 and r_2 and these are independent; elsewhere (at
/// borders where not all of a jet can be computed) it is what the lagged operator gives, too.
void add_curvature_stress(const GeometryBlock& geometry, const GeometryBlock& origin,
                          const FormStiffness& C, const Stress& sigma);
/// c_mk of what follows, where no M is given.
void add_curvature_factors(const GeometryBlock& geometry, const FormStiffness& C,
                           const TangentFactors& to);
/// h_mk += c_mk n nᵀ for all m ≤ k, and, where M is given, Σ_a M_a ∂²B_a:
///   δ²B_ij = −2 (n·δr_k)(r^k·L_ij δr) − B_ij G^kl (n·δr_k)(n·δr_l),
/// which follows from δn = −r^k (n·δr_k) and δr^k = −r^l (r^k·δr_l) + n G^kl (n·δr_l).
void add_curvature_tangent(const GeometryBlock& geometry, const FormStiffness& C,
                           const BlockTensor* M, const JetTangent& h);

}  // namespace deform
