/// Energies that are quadratic in the change of a fundamental form: force and tangents follow from
/// the coefficients alone.
#pragma once

#include <algorithm>
#include <array>

#include "deform/model/energy_term.h"

namespace deform {

/// The fundamental forms: G (3) and B (6).
enum class Form : std::uint8_t { metric, curvature };

/// C_ab of a block's samples, a and b from 11, 12, 22; symmetric; 0 until it is set.
class DEFORM_API FormStiffness {
 public:
  explicit FormStiffness(Index size) {
    for (auto& values : c_) std::fill_n(values.begin(), size, 0.0);
  }
  [[nodiscard]] double& operator()(Pair a, Pair b, Index sample) {
    return c_[place(a, b)][static_cast<std::size_t>(sample)];
  }
  [[nodiscard]] double operator()(Pair a, Pair b, Index sample) const {
    return c_[place(a, b)][static_cast<std::size_t>(sample)];
  }
  /// C_ab at all samples.
  [[nodiscard]] const double* values(Pair a, Pair b) const { return c_[place(a, b)].data(); }
  /// Those of factor · √det G⁰ [(1 − ν) tr(M²) + ν tr(M)²], M = G⁰⁻¹ X, as a quadratic form of X:
  /// an isotropic material; `factor`: one number a sample of the block.
  void set_isotropic(const GeometryBlock& rest, const double* factor, double nu);
  /// The symmetric matrix of one sample.
  void set(Index sample, const Eigen::Matrix3d& c) {
    for (const Pair a : kPairs)
      for (const Pair b : kPairs)
        if (a <= b) (*this)(a, b, sample) = c(slot(a), slot(b));
  }

 private:
  static constexpr std::size_t place(Pair a, Pair b) {
    const int i = slot(a) < slot(b) ? slot(a) : slot(b), j = slot(a) + slot(b) - i;
    return static_cast<std::size_t>(i == 0 ? j : i + j + 1);  // 00 01 02 11 12 22
  }
  std::array<std::array<double, kBlock>, 6> c_;  // as far as the block goes
};

/// A density w = ½ Σ_ab C_ab (T_a − T⁰_a)(T_b − T⁰_b) per parameter area [J/m²] for T = G or B; the
/// sum runs over 11, 12, 22, the mixed pair once, and C (symmetric, positive semidefinite) depends
/// on the rest state and the place alone.
///
/// Metric: σ_m = Σ_a S_a ∂G_a/∂r_m with S = C (G − G⁰), K_mn = Σ_a S_a ∂²G_a/∂r_m∂r_n.
/// Curvature: δB_ij = n·L_ij δr with L_ij = D_ij − Γ^k_ij D_k, so the force is −Σ L_ijᵀ A M_ij n
/// with M = C (B − B⁰); as L_ij r = B_ij n, lagging Γ and n leaves the symmetric positive
/// semidefinite operator Σ L_aᵀ A C_ab L_b: no division by B.
class DEFORM_API QuadraticTerm : public JetTerm {
 public:
  explicit QuadraticTerm(Form form) : form_(form) {}
  ~QuadraticTerm() override;

  /// C at the samples of a block. Const, thread-safe.
  virtual void stiffness(const GeometryBlock& rest, FormStiffness& c) const = 0;
  /// Whether C is diagonal everywhere: the lagged operator then couples fewer nodes.
  [[nodiscard]] virtual bool is_diagonal() const { return false; }

  [[nodiscard]] SampleRole role() const override {
    return form_ == Form::metric ? SampleRole::membrane : SampleRole::bending;
  }
  [[nodiscard]] TermTraits traits() const final;
  [[nodiscard]] std::vector<Derivative> dependence() const final;
  [[nodiscard]] Geometry::Detail reads() const final {
    return form_ == Form::metric ? Geometry::Detail::metric : Geometry::Detail::second;
  }
  void energy_density(const SampleBlock& block, Values density) const final;
  [[nodiscard]] std::vector<Coupling> couplings() const final;
  void stress(const SampleBlock& block, const Stress& sigma) const final;
  void affine_stress(const SampleBlock& block, const AffineStress& sigma) const final;
  void tangent(const SampleBlock& block, Tangent kind, const JetTangent& h) const final;
  [[nodiscard]] TangentShape tangent_shape(Tangent kind) const final;
  void tangent_factors(const SampleBlock& block, Tangent kind, const TangentFactors& c) const final;

 private:
  void add_metric_stress(const SampleBlock& block, const FormStiffness& C,
                         const AffineStress& sigma) const;
  void add_curvature_stress(const SampleBlock& block, const FormStiffness& C,
                            const AffineStress& sigma) const;

  Form form_;
};

/// C of Σ w_ij (T_ij − T⁰_ij)² over all four ij, times `factor`: the weighted norms of (17), (18).
[[nodiscard]] DEFORM_API Eigen::Matrix3d weighted_norm_stiffness(double factor,
                                                                 const PairWeights& weights);

}  // namespace deform
