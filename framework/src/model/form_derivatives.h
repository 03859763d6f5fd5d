/// First and second derivatives of the curvature tensor B with respect to the jet, for a block of
/// samples at once.
#pragma once

#include <array>

#include "deform/geometry/geometry.h"
#include "deform/model/quadratic_term.h"
#include "deform/model/tangent.h"

namespace deform {

/// Numbers of the samples of a block.
using BlockValues = std::array<double, kBlock>;
/// T_11, T_12, T_22 at each of them.
using BlockTensor = std::array<BlockValues, 3>;

/// C x for a tensor x.
void multiply(const FormStiffness& c, const BlockTensor& x, Index size, BlockTensor& out);

/// δB_a = n · Σ_m L_am δ(D_m r): the rows of L_ij = D_ij − Γ^k_ij D_k, a = 11, 12, 22, over the
/// jet's five derivatives: L_am is 1 where D_m is D_a, −Γ^m_a for m = 1, 2, else 0.
class CurvatureRows {
 public:
  explicit CurvatureRows(const GeometryBlock& geometry) : geometry_(geometry) {}

  /// Σ_ab L_am C_ab L_bk, m ≤ k counted from 0.
  void quadratic(const FormStiffness& c, int m, int k, BlockValues& out) const;
  /// Σ_a L_am M_a.
  void combined(const BlockTensor& M, int m, BlockValues& out) const;

 private:
  [[nodiscard]] const double* gamma(int m, int a) const {
    return geometry_.gamma(m + 1, kPairs[static_cast<std::size_t>(a)]).data();
  }
  GeometryBlock geometry_;
};

/// h_mk += c_mk n nᵀ for all m ≤ k, c_mk being Σ_ab L_am C_ab L_bk, and, where M is given, Σ_a M_a
/// ∂²B_a:
///   δ²B_ij = −2 (n·δr_k)(r^k·L_ij δr) − B_ij G^kl (n·δr_k)(n·δr_l),
/// which follows from δn = −r^k (n·δr_k) and δr^k = −r^l (r^k·δr_l) + n G^kl (n·δr_l).
void add_curvature_tangent(const GeometryBlock& geometry, const FormStiffness& c,
                           const BlockTensor* M, const JetTangent& h);

}  // namespace deform
