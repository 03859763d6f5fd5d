#include "deform/model/quadratic_term.h"

#include <algorithm>
#include <cmath>

#include "deform/kernel.h"

#include "model/form_derivatives.h"
#include "model/form_kernels.h"

namespace deform {
namespace {

using Eigen::Matrix3d;

ConstValues form(const GeometryBlock& geometry, Form which, Pair a) {
  return which == Form::metric ? geometry.G(a) : geometry.B(a);
}

DEFORM_KERNEL void subtract(Index size, const double* __restrict a, const double* __restrict b,
                            double* __restrict out) {
  for (Index s = 0; s < size; ++s) out[s] = a[s] - b[s];
}

/// T_a − T⁰_a, T⁰ being that of the origin.
void find_change(const SampleBlock& block, Form which, BlockTensor& x) {
  for (const Pair a : kPairs)
    subtract(block.size(), form(block.now, which, a).data(), form(block.origin, which, a).data(),
             x[static_cast<std::size_t>(slot(a))].data());
}

/// G − G⁰ as it was predicted at the lagged state: δG_ij = r_i·δr_j + r_j·δr_i without δr_i·δr_j;
/// over a step, whose end moves by 2 δr, without 2 δr_i·δr_j.
void find_predicted_change(const SampleBlock& block, BlockTensor& x) {
  find_change(block, Form::metric, x);
  const double part = block.now.has_mean_strains() ? 2 : 1;
  for (Index s = 0; s < block.size(); ++s) {
    const Vec3 d_1 = block.now.r(Derivative::d1)[s] - block.lagged.r(Derivative::d1)[s];
    const Vec3 d_2 = block.now.r(Derivative::d2)[s] - block.lagged.r(Derivative::d2)[s];
    const auto i = static_cast<std::size_t>(s);
    x[0][i] -= part * d_1.dot(d_1), x[1][i] -= part * d_1.dot(d_2), x[2][i] -= part * d_2.dot(d_2);
  }
}

/// C of 2 factor area [(1 − ν) A + ν v vᵀ] with tr(M²) = xᵀ A x and tr(M) = v·x, x = (X_11, X_12,
/// X_22).
DEFORM_KERNEL void find_isotropic(Index size, const double* __restrict R_11,
                                  const double* __restrict R_12, const double* __restrict R_22,
                                  const double* __restrict area, const double* __restrict factor,
                                  double nu, const std::array<double*, 6>& C) {
  double *const c_0 = C[0], *const c_1 = C[1], *const c_2 = C[2], *const c_3 = C[3],
                *const c_4 = C[4], *const c_5 = C[5];
#pragma GCC ivdep
  for (Index s = 0; s < size; ++s) {
    const double g_11 = R_11[s], g_12 = R_12[s], g_22 = R_22[s];
    const double f = 2 * (factor[s] * area[s]), v_12 = 2 * g_12;
    c_0[s] = f * ((1 - nu) * (g_11 * g_11) + nu * g_11 * g_11);
    c_1[s] = f * ((1 - nu) * (2 * g_11 * g_12) + nu * g_11 * v_12);
    c_2[s] = f * ((1 - nu) * (g_12 * g_12) + nu * g_11 * g_22);
    c_3[s] = f * ((1 - nu) * (2 * (g_11 * g_22 + g_12 * g_12)) + nu * v_12 * v_12);
    c_4[s] = f * ((1 - nu) * (2 * g_12 * g_22) + nu * v_12 * g_22);
    c_5[s] = f * ((1 - nu) * (g_22 * g_22) + nu * g_22 * g_22);
  }
}

/// Σ_a S_a ∂²G_a/∂r_m∂r_n is K_mn times the identity: 2 S_11, S_12, 2 S_22, in place.
DEFORM_KERNEL void stress_to_stiffness(Index size, double* __restrict K_11,
                                       double* __restrict K_22) {
  for (Index s = 0; s < size; ++s) K_11[s] *= 2, K_22[s] *= 2;
}

/// The positive semidefinite part of K, a (symmetric) 2 × 2 matrix at each sample, in place: with
/// eigenvalues t ± R it is K, 0, or (t + R)(K − (t − R) I)/(2R).
DEFORM_KERNEL void make_semidefinite(Index size, double* __restrict K_11, double* __restrict K_12,
                                     double* __restrict K_22) {
  for (Index s = 0; s < size; ++s) {
    const double t = 0.5 * (K_11[s] + K_22[s]), d = 0.5 * (K_11[s] - K_22[s]);
    const double R = std::sqrt(d * d + K_12[s] * K_12[s]);
    const double high = t + R, low = t - R;
    const double some = high / (R > 0 ? 2 * R : 1.0);
    const double of_K = low >= 0 ? 1.0 : high > 0 ? some : 0.0;
    const double of_I = low >= 0 ? 0.0 : -of_K * low;
    K_11[s] = of_K * K_11[s] + of_I;
    K_12[s] *= of_K;
    K_22[s] = of_K * K_22[s] + of_I;
  }
}

/// The constant parts of a potential's stress.
Stress constants(const AffineStress& sigma) {
  Stress c;
  for (int m = 0; m < kDerivatives; ++m)
    c.sigma[static_cast<std::size_t>(m)] = sigma.c(static_cast<Derivative>(m));
  return c;
}

/// Where C is diagonal, second derivatives do not couple.
const std::vector<Coupling>& couplings_of_curvature(bool is_diagonal) {
  using enum Derivative;
  static const std::vector<Coupling> all = couplings_among({d1, d2, d11, d12, d22});
  static const std::vector<Coupling> some = [] {
    std::vector<Coupling> found;
    for (const Pair ij : kPairs)
      for (const Coupling& c : couplings_among({second(ij), d1, d2}))
        if (std::ranges::find(found, c) == found.end()) found.push_back(c);
    return found;
  }();
  return is_diagonal ? some : all;
}

void add_metric_tangent(const SampleBlock& block, const FormStiffness& C, Tangent kind,
                        const JetTangent& h) {
  if (kind == Tangent::gauss_newton) return add_metric_tangent(block.now, C, nullptr, h);
  const Index size = block.size();
  BlockTensor x, K;
  if (kind == Tangent::mixed)
    find_predicted_change(block, x);
  else
    find_change(block, Form::metric, x);
  multiply(C, x, size, K);
  stress_to_stiffness(size, K[0].data(), K[2].data());
  if (kind == Tangent::projected) make_semidefinite(size, K[0].data(), K[1].data(), K[2].data());
  add_metric_tangent(block.now, C, &K, h);
}

}  // namespace

void FormStiffness::set_isotropic(const GeometryBlock& rest, const double* factor, double nu) {
  std::array<double*, 6> C{};
  for (std::size_t q = 0; q < 6; ++q) C[q] = c_[q].data();
  find_isotropic(rest.size(), rest.reciprocal(Pair::p11).data(), rest.reciprocal(Pair::p12).data(),
                 rest.reciprocal(Pair::p22).data(), rest.area_element().data(), factor, nu, C);
}

QuadraticTerm::~QuadraticTerm() = default;

TermTraits QuadraticTerm::traits() const {
  return {.potential = true,
          .lagged = Lagged::symmetric,
          .semidefinite = form_ == Form::curvature,
          .strains = true,
          .direct_stress = true};
}

std::vector<Derivative> QuadraticTerm::dependence() const {
  if (form_ == Form::metric) return {Derivative::d1, Derivative::d2};
  return JetTerm::dependence();
}

void QuadraticTerm::energy_density(const SampleBlock& block, Values density) const {
  FormStiffness c(block.size());
  stiffness(block.rest, c);
  BlockTensor x, stress;
  find_change(block, form_, x);
  multiply(c, x, block.size(), stress);
  for (std::size_t a = 0; a < 3; ++a)
    for (std::size_t s = 0; s < static_cast<std::size_t>(block.size()); ++s)
      density[s] += 0.5 * x[a][s] * stress[a][s];
}

std::vector<Coupling> QuadraticTerm::couplings() const {
  using enum Derivative;
  if (form_ == Form::metric) return couplings_among({d1, d2});
  return couplings_of_curvature(is_diagonal());
}

void QuadraticTerm::stress(const SampleBlock& block, const Stress& sigma) const {
  FormStiffness C(block.size());
  stiffness(block.rest, C);
  // L_ij r is B_ij n of one state, not of a mean of two.
  if (form_ == Form::curvature && !block.now.has_mean_strains())
    return deform::add_curvature_stress(block.now, block.origin, C, sigma);
  BlockTensor x, S;
  find_change(block, form_, x);
  multiply(C, x, block.size(), S);
  if (form_ == Form::curvature)
    add_normal_stress(block.now, S, sigma);
  else
    deform::add_metric_stress(block.now, S, sigma);
}

void QuadraticTerm::affine_stress(const SampleBlock& block, const AffineStress& sigma) const {
  FormStiffness C(block.size());
  stiffness(block.rest, C);
  SampleBlock lagged = block;
  lagged.now = block.lagged;
  if (form_ == Form::metric)
    add_metric_stress(lagged, C, sigma);
  else
    add_curvature_stress(lagged, C, sigma);
}

void QuadraticTerm::add_metric_stress(const SampleBlock& block, const FormStiffness& C,
                                      const AffineStress& sigma) const {
  BlockTensor x, K;
  find_change(block, Form::metric, x);
  multiply(C, x, block.size(), K);
  stress_to_stiffness(block.size(), K[0].data(), K[2].data());
  for (const int i : {1, 2})
    for (const int j : {1, 2})
      add_numbers(block.size(), K[static_cast<std::size_t>(i + j - 2)].data(),
                  sigma.k(first(i), first(j)).data());
}

void QuadraticTerm::add_curvature_stress(const SampleBlock& block, const FormStiffness& C,
                                         const AffineStress& sigma) const {
  const Index size = block.size();
  const CurvatureStiffness c(block.now, C);
  for (const auto& [m, n] : couplings_of_curvature(is_diagonal()))
    add_numbers(size, c(std::min(slot(m), slot(n)) - 1, std::max(slot(m), slot(n)) - 1),
                sigma.k(m, n).data());
  // What the change has beside B: −B⁰.
  BlockTensor x, M;
  for (const Pair a : kPairs) {
    const ConstValues origin = block.origin.B(a);
    BlockValues& out = x[static_cast<std::size_t>(slot(a))];
    for (std::size_t s = 0; s < origin.size(); ++s) out[s] = -origin[s];
  }
  multiply(C, x, size, M);
  add_normal_stress(block.now, M, constants(sigma));
}

void QuadraticTerm::tangent(const SampleBlock& block, Tangent kind, const JetTangent& h) const {
  FormStiffness c(block.size());
  stiffness(block.rest, c);
  if (form_ == Form::metric) return add_metric_tangent(block, c, kind, h);
  // What else is in the Hessian is small beside C δB δB where the surface is not crumpled, and has
  // as many negative as positive eigenvalues: the projected tangent leaves it out.
  if (is_semidefinite(kind)) return add_curvature_tangent(block.now, c, nullptr, h);
  BlockTensor x, M;
  find_change(block, Form::curvature, x);
  multiply(c, x, block.size(), M);
  add_curvature_tangent(block.now, c, &M, h);
}

TangentShape QuadraticTerm::tangent_shape(Tangent kind) const {
  return form_ == Form::curvature && is_semidefinite(kind) ? TangentShape::normal
                                                           : TangentShape::blocks;
}

void QuadraticTerm::tangent_factors(const SampleBlock& block, Tangent /*kind*/,
                                    const TangentFactors& c) const {
  FormStiffness C(block.size());
  stiffness(block.rest, C);
  add_curvature_factors(block.now, C, c);
}

Eigen::Matrix3d weighted_norm_stiffness(double factor, const PairWeights& weights) {
  Matrix3d c = Matrix3d::Zero();
  for (const Pair ij : kPairs) c(slot(ij), slot(ij)) = 2 * factor * multiplicity(ij) * weights(ij);
  return c;
}

}  // namespace deform
