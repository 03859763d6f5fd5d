#include <deform/model/energy_term.h>

namespace {
using namespace deform;

struct Parameters {
  PairWeights xi = PairWeights::all(1e-6);
  static void declare(Declaration<Parameters>& d) {
    d("xi", &Parameters::xi, "N·m", "resistance to bending, one number or [[11,12],[21,22]]")
        .at_least(0);
  }
};

/// ½ Σ xi_ij (B_ij − B⁰_ij)² with its whole gradient: δB_ij = n·L_ij δr with L_ij = D_ij − Γ^k_ij
/// D_k, so the force is −Σ L_ijᵀ A β_ij n, and β_ij n = xi_ij (L_ij r − B⁰_ij n) as L_ij r = B_ij
/// n: no division by B. Lagging Γ and n leaves the symmetric positive semidefinite operator Σ L_ijᵀ
/// A xi_ij L_ij.
class BendingVariational final : public JetTerm {
 public:
  BendingVariational(const Parameters& p, const Setup& /*setup*/) : xi_(p.xi) {}

  [[nodiscard]] TermTraits traits() const override {
    return {.potential = true, .lagged = Lagged::symmetric, .semidefinite = true};
  }

  void energy_density(const SampleBlock& block, Values density) const override {
    add_weighted_norm(0.5, xi_, block, &GeometryBlock::B, density);
  }

  [[nodiscard]] std::vector<Coupling> couplings() const override {
    std::vector<Coupling> all;
    for (const Pair ij : kPairs)
      for (const Coupling& c : couplings_among({second(ij), Derivative::d1, Derivative::d2}))
        all.push_back(c);
    return all;
  }

  void affine_stress(const SampleBlock& block, const AffineStress& sigma) const override {
    for (const Pair ij : kPairs) add_pair(block, ij, sigma);
  }

 private:
  /// Rows and columns of L_ijᵀ xi_ij L_ij and L_ijᵀ (−xi_ij B⁰_ij n) in the basis (D_ij, D_1, D_2),
  /// in which L_ij is (1, −Γ¹_ij, −Γ²_ij).
  void add_pair(const SampleBlock& block, Pair ij, const AffineStress& sigma) const {
    const std::array<Derivative, 3> basis{second(ij), Derivative::d1, Derivative::d2};
    const double xi = multiplicity(ij) * xi_(ij);
    const ConstValues gamma_1 = block.lagged.gamma(1, ij), gamma_2 = block.lagged.gamma(2, ij);
    const ConstValues B0 = block.rest.B(ij);
    const ConstVectors n = block.lagged.n();
    std::array<std::array<Values, 3>, 3> k;
    for (std::size_t a = 0; a < 3; ++a)
      for (std::size_t b = 0; b < 3; ++b) k[a][b] = sigma.k(basis[a], basis[b]);
    for (std::size_t s = 0; s < B0.size(); ++s) {
      const std::array<double, 3> L{1.0, -gamma_1[s], -gamma_2[s]};
      const Vec3 rest = xi * B0[s] * n[static_cast<Index>(s)];
      for (std::size_t a = 0; a < 3; ++a) {
        for (std::size_t b = 0; b < 3; ++b) k[a][b][s] += xi * L[a] * L[b];
        sigma.c(basis[a]).add(static_cast<Index>(s), -L[a] * rest);
      }
    }
  }

  PairWeights xi_;
};

}  // namespace

DEFORM_PLUGIN(BendingVariational, Parameters, .name = "bending_variational", .version = "1.0",
              .summary = "resistance to bending, the exact gradient of its energy",
              .formula = "w = ½ Σ xi_ij (B_ij − B⁰_ij)², f = −Σ L_ijᵀ A β_ij n",
              .source = "the gradient of Wu & Melo (18) with the terms that (19) drops")
