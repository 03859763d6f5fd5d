#include <deform/model/quadratic_term.h>
#include <deform/plugin/field.h>
#include <deform/surface/surface.h>

namespace {
using namespace deform;

struct Parameters {
  PairWeightsField eta = PairWeights::all(0.01);
  static void declare(Declaration<Parameters>& d) {
    d("eta", &Parameters::eta, "N/m",
      "resistance to metric variation: a number, a formula or a map, or [[11,12],[21,22]] of such")
        .at_least(0);
  }
};

/// ¼ Σ eta_ij (G_ij − G⁰_ij)²: its force is −Σ D_iᵀ A α_ij r_j with α_ij = eta_ij (G_ij − G⁰_ij)
/// (20).
class Stretching final : public QuadraticTerm {
 public:
  Stretching(const Parameters& p, const Setup& setup)
      : QuadraticTerm(Form::metric),
        eta_(p.eta.at_samples(setup.surface(), setup.surface().samples(SampleRole::membrane))) {}

  [[nodiscard]] bool is_diagonal() const override { return true; }
  void stiffness(const GeometryBlock& rest, FormStiffness& c) const override {
    for (Index s = 0; s < rest.size(); ++s)
      c.set(s, weighted_norm_stiffness(0.25, eta_[rest.first() + s]));
  }

 private:
  WeightsAtSamples eta_;
};

}  // namespace

DEFORM_PLUGIN(Stretching, Parameters, .name = "stretching", .version = "1.0",
              .summary = "resistance to stretching and shearing",
              .formula = "w = ¼ Σ eta_ij (G_ij − G⁰_ij)²",
              .source = "Wu & Melo (19), (20), first part")
