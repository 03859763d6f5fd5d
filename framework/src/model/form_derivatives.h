/// First and second derivatives of the curvature tensor B with respect to the jet.
#pragma once

#include "deform/geometry/geometry.h"
#include "deform/model/tangent.h"

namespace deform {

/// δB_a = n · Σ_m L_am δ(D_m r): the rows of L_ij = D_ij − Γ^k_ij D_k at a sample, a = 11, 12, 22,
/// over the jet's five derivatives.
struct CurvatureRows {
  CurvatureRows(const GeometryBlock& geometry, Index s);
  Eigen::Matrix<double, 3, kJet> rows;
};

/// Adds Σ_a M_a ∂²B_a to the tangent at a sample:
///   δ²B_ij = −2 (n·δr_k)(r^k·L_ij δr) − B_ij G^kl (n·δr_k)(n·δr_l),
/// which follows from δn = −r^k (n·δr_k) and δr^k = −r^l (r^k·δr_l) + n G^kl (n·δr_l).
void add_curvature_hessian(const GeometryBlock& geometry, Index s, const CurvatureRows& L,
                           const Vec3& M, const JetTangent& h);

}  // namespace deform
