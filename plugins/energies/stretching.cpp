#include <deform/model/energy_term.h>

namespace {
using namespace deform;

struct Parameters {
  PairWeights eta = PairWeights::all(0.01);
  static void declare(Declaration<Parameters>& d) {
    d("eta", &Parameters::eta, "N/m",
      "resistance to metric variation, one number or [[11,12],[21,22]]")
        .at_least(0);
  }
};

/// ¼ Σ eta_ij (G_ij − G⁰_ij)²: its force is −Σ D_iᵀ A α_ij r_j with α_ij = eta_ij (G_ij − G⁰_ij)
/// (20).
class Stretching final : public JetTerm {
 public:
  Stretching(const Parameters& p, const Setup& /*setup*/) : eta_(p.eta) {}

  [[nodiscard]] TermTraits traits() const override {
    return {.potential = true, .lagged = Lagged::symmetric};
  }
  [[nodiscard]] SampleRole role() const override { return SampleRole::membrane; }

  void energy_density(const SampleBlock& block, Values density) const override {
    add_weighted_norm(0.25, eta_, block, &GeometryBlock::G, density);
  }

  [[nodiscard]] std::vector<Coupling> couplings() const override {
    return couplings_among({Derivative::d1, Derivative::d2});
  }
  void affine_stress(const SampleBlock& block, const AffineStress& sigma) const override {
    for (const int i : {1, 2})
      for (const int j : {1, 2}) {
        const ConstValues G = block.lagged.G(pair(i, j)), G0 = block.rest.G(pair(i, j));
        const Values k = sigma.k(first(i), first(j));
        for (std::size_t s = 0; s < k.size(); ++s) k[s] += eta_(pair(i, j)) * (G[s] - G0[s]);
      }
  }

 private:
  PairWeights eta_;
};

}  // namespace

DEFORM_PLUGIN(Stretching, Parameters, .name = "stretching", .version = "1.0",
              .summary = "resistance to stretching and shearing",
              .formula = "w = ¼ Σ eta_ij (G_ij − G⁰_ij)²",
              .source = "Wu & Melo (19), (20), first part")
