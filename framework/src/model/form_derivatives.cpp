#include "model/form_derivatives.h"

namespace deform {

CurvatureRows::CurvatureRows(const GeometryBlock& geometry, Index s) {
  rows.setZero();
  const auto i = static_cast<std::size_t>(s);
  for (const Pair ij : kPairs) {
    rows(slot(ij), slot(second(ij)) - 1) = 1;
    for (const int k : {1, 2}) rows(slot(ij), k - 1) = -geometry.gamma(k, ij)[i];
  }
}

void add_curvature_hessian(const GeometryBlock& geometry, Index s, const CurvatureRows& L,
                           const Vec3& M, const JetTangent& h) {
  const auto i = static_cast<std::size_t>(s);
  const Vec3 n = geometry.n()[s];
  Eigen::Matrix2d reciprocal;  // G^kl
  reciprocal << geometry.reciprocal(Pair::p11)[i], geometry.reciprocal(Pair::p12)[i],
      geometry.reciprocal(Pair::p12)[i], geometry.reciprocal(Pair::p22)[i];
  Eigen::Matrix<double, 3, 2> tangents;
  tangents << geometry.r(Derivative::d1)[s], geometry.r(Derivative::d2)[s];
  const Eigen::Matrix<double, 3, 2> dual = tangents * reciprocal;  // r^k

  const Eigen::Matrix<double, kJet, 1> lambda = L.rows.transpose() * M;  // Σ_a M_a L_am
  double MB = 0;
  for (const Pair a : kPairs) MB += M[slot(a)] * geometry.B(a)[i];

  for (int m = 0; m < kJet; ++m)
    for (int k = m; k < kJet; ++k) {
      Eigen::Matrix3d block = Eigen::Matrix3d::Zero();
      if (m < 2) block -= lambda[k] * n * dual.col(m).transpose();
      if (k < 2) block -= lambda[m] * dual.col(k) * n.transpose();
      if (m < 2 && k < 2) block -= MB * reciprocal(m, k) * n * n.transpose();
      h.add(s, static_cast<Derivative>(m + 1), static_cast<Derivative>(k + 1), block);
    }
}

}  // namespace deform
