#include "deform/model/quadratic_term.h"

#include <algorithm>
#include <tuple>

#include "model/form_derivatives.h"
#include "model/semidefinite.h"

namespace deform {
namespace {

using Eigen::Matrix3d;

/// T_a − T⁰_a at a sample, T⁰ being that of the origin.
Vec3 change(const SampleBlock& block, Form form, Index s) {
  Vec3 x;
  for (const Pair a : kPairs) {
    const auto i = static_cast<std::size_t>(s);
    x[slot(a)] = form == Form::metric ? block.now.G(a)[i] - block.origin.G(a)[i]
                                      : block.now.B(a)[i] - block.origin.B(a)[i];
  }
  return x;
}

Matrix3d matrix_of(const FormStiffness& c, Index s) {
  Matrix3d m;
  for (const Pair a : kPairs)
    for (const Pair b : kPairs) m(slot(a), slot(b)) = c(a, b, s);
  return m;
}

/// 2 S_11, S_12, 2 S_22: Σ_a S_a ∂²G_a/∂r_m∂r_n is this times the identity.
Eigen::Matrix2d metric_stress(const Vec3& S) {
  Eigen::Matrix2d k;
  k << 2 * S[0], S[1], S[1], 2 * S[2];
  return k;
}

/// G − G⁰ as it was foreseen at the lagged state: δG_ij = r_i·δr_j + r_j·δr_i without δr_i·δr_j.
Vec3 foreseen_change(const SampleBlock& block, Index s) {
  const Vec3 d_1 = block.now.r(Derivative::d1)[s] - block.lagged.r(Derivative::d1)[s];
  const Vec3 d_2 = block.now.r(Derivative::d2)[s] - block.lagged.r(Derivative::d2)[s];
  return change(block, Form::metric, s) - Vec3(d_1.dot(d_1), d_1.dot(d_2), d_2.dot(d_2));
}

void add_metric_tangent(const SampleBlock& block, Index s, const Matrix3d& C, Tangent kind,
                        const JetTangent& h) {
  const std::array<Vec3, 2> r{block.now.r(Derivative::d1)[s], block.now.r(Derivative::d2)[s]};
  // ∂G_a/∂r_m: (2 r_1, 0), (r_2, r_1), (0, 2 r_2).
  std::array<Eigen::Matrix3d, 2> g;  // columns a
  g[0] << 2 * r[0], r[1], Vec3::Zero();
  g[1] << Vec3::Zero(), r[0], 2 * r[1];
  Eigen::Matrix2d k = Eigen::Matrix2d::Zero();
  if (kind != Tangent::gauss_newton)
    k = metric_stress(C * (kind == Tangent::foreseen ? foreseen_change(block, s)
                                                     : change(block, Form::metric, s)));
  if (kind == Tangent::projected) k = positive_part(k);
  for (const int m : {1, 2})
    for (int n = m; n <= 2; ++n) {
      Matrix3d block_mn =
          g[static_cast<std::size_t>(m - 1)] * C * g[static_cast<std::size_t>(n - 1)].transpose();
      block_mn.diagonal().array() += k(m - 1, n - 1);
      h.add(s, first(m), first(n), block_mn);
    }
}

void add_curvature_tangent(const SampleBlock& block, Index s, const Matrix3d& C, Tangent kind,
                           const JetTangent& h) {
  const CurvatureRows L(block.now, s);
  const Eigen::Matrix<double, kJet, kJet> rows = L.rows.transpose() * C * L.rows;
  const Vec3 n = block.now.n()[s];
  const Matrix3d nn = n * n.transpose();
  const auto derivative = [](int m) { return static_cast<Derivative>(m + 1); };
  for (int m = 0; m < kJet; ++m)
    for (int k = m; k < kJet; ++k) h.add(s, derivative(m), derivative(k), rows(m, k) * nn);
  // What else is in the Hessian is small beside the above where the surface is not crumpled, and
  // has as many negative as positive eigenvalues: the projected tangent leaves it out.
  if (is_semidefinite(kind)) return;
  add_curvature_hessian(block.now, s, L, C * change(block, Form::curvature, s), h);
}

}  // namespace

QuadraticTerm::~QuadraticTerm() = default;

TermTraits QuadraticTerm::traits() const {
  return {.potential = true,
          .lagged = Lagged::symmetric,
          .semidefinite = form_ == Form::curvature,
          .strains = true};
}

std::vector<Derivative> QuadraticTerm::dependence() const {
  if (form_ == Form::metric) return {Derivative::d1, Derivative::d2};
  return JetTerm::dependence();
}

void QuadraticTerm::energy_density(const SampleBlock& block, Values density) const {
  FormStiffness c;
  stiffness(block.rest, c);
  for (Index s = 0; s < block.size(); ++s) {
    const Vec3 x = change(block, form_, s);
    density[static_cast<std::size_t>(s)] += 0.5 * x.dot(matrix_of(c, s) * x);
  }
}

std::vector<Coupling> QuadraticTerm::couplings() const {
  using enum Derivative;
  if (form_ == Form::metric) return couplings_among({d1, d2});
  if (!is_diagonal()) return couplings_among({d1, d2, d11, d12, d22});
  std::vector<Coupling> all;
  for (const Pair ij : kPairs)
    for (const Coupling& c : couplings_among({second(ij), d1, d2}))
      if (std::ranges::find(all, c) == all.end()) all.push_back(c);
  return all;
}

void QuadraticTerm::affine_stress(const SampleBlock& block, const AffineStress& sigma) const {
  FormStiffness stiffnesses;
  stiffness(block.rest, stiffnesses);
  SampleBlock lagged = block;
  lagged.now = block.lagged;
  if (form_ == Form::metric) {
    std::array<std::array<Values, 2>, 2> k;
    for (const int i : {1, 2})
      for (const int j : {1, 2})
        k[static_cast<std::size_t>(i - 1)][static_cast<std::size_t>(j - 1)] =
            sigma.k(first(i), first(j));
    for (Index s = 0; s < block.size(); ++s) {
      const Eigen::Matrix2d S =
          metric_stress(matrix_of(stiffnesses, s) * change(lagged, Form::metric, s));
      for (std::size_t i = 0; i < 2; ++i)
        for (std::size_t j = 0; j < 2; ++j)
          k[i][j][static_cast<std::size_t>(s)] += S(static_cast<Index>(i), static_cast<Index>(j));
    }
    return;
  }
  std::vector<std::tuple<int, int, Values>> k;
  for (const auto& [m, n] : couplings())
    k.emplace_back(slot(m) - 1, slot(n) - 1, sigma.k(static_cast<Derivative>(slot(m)), n));
  std::array<Vectors, kJet> c;
  for (int m = 0; m < kJet; ++m)
    c[static_cast<std::size_t>(m)] = sigma.c(static_cast<Derivative>(m + 1));
  for (Index s = 0; s < block.size(); ++s) {
    const Matrix3d C = matrix_of(stiffnesses, s);
    const CurvatureRows L(block.lagged, s);
    const Eigen::Matrix<double, kJet, kJet> rows = L.rows.transpose() * C * L.rows;
    for (const auto& [m, n, values] : k) values[static_cast<std::size_t>(s)] += rows(m, n);
    Vec3 B0;
    for (const Pair a : kPairs) B0[slot(a)] = block.origin.B(a)[static_cast<std::size_t>(s)];
    const Eigen::Matrix<double, kJet, 1> rest = L.rows.transpose() * (C * B0);
    const Vec3 n = block.lagged.n()[s];
    for (int m = 0; m < kJet; ++m) c[static_cast<std::size_t>(m)].add(s, -rest[m] * n);
  }
}

void QuadraticTerm::tangent(const SampleBlock& block, Tangent kind, const JetTangent& h) const {
  FormStiffness c;
  stiffness(block.rest, c);
  for (Index s = 0; s < block.size(); ++s) {
    if (form_ == Form::metric) {
      add_metric_tangent(block, s, matrix_of(c, s), kind, h);
    } else {
      add_curvature_tangent(block, s, matrix_of(c, s), kind, h);
    }
  }
}

Eigen::Matrix3d weighted_norm_stiffness(double factor, const PairWeights& weights) {
  Matrix3d c = Matrix3d::Zero();
  for (const Pair ij : kPairs) c(slot(ij), slot(ij)) = 2 * factor * multiplicity(ij) * weights(ij);
  return c;
}

}  // namespace deform
