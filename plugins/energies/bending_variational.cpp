#include <deform/model/quadratic_term.h>
#include <deform/plugin/field.h>
#include <deform/surface/surface.h>

namespace {
using namespace deform;

struct Parameters {
  PairWeightsField xi = PairWeights::all(1e-6);
  static void declare(Declaration<Parameters>& d) {
    d("xi", &Parameters::xi, "N·m",
      "resistance to bending: a number, a formula or a map, or [[11,12],[21,22]] of such")
        .at_least(0);
  }
};

/// ½ Σ xi_ij (B_ij − B⁰_ij)² with its whole gradient −Σ L_ijᵀ A β_ij n, β_ij n = xi_ij (L_ij r −
/// B⁰_ij n).
class BendingVariational final : public QuadraticTerm {
 public:
  BendingVariational(const Parameters& p, const Setup& setup)
      : QuadraticTerm(Form::curvature),
        xi_(p.xi.at_samples(setup.surface(), setup.surface().samples(SampleRole::bending))) {}

  [[nodiscard]] bool is_diagonal() const override { return true; }
  void stiffness(const GeometryBlock& rest, FormStiffness& c) const override {
    for (Index s = 0; s < rest.size(); ++s)
      c.set(s, weighted_norm_stiffness(0.5, xi_[rest.first() + s]));
  }

 private:
  WeightsAtSamples xi_;
};

}  // namespace

DEFORM_PLUGIN(BendingVariational, Parameters, .name = "bending_variational", .version = "1.0",
              .summary = "resistance to bending, the exact gradient of its energy",
              .formula = "w = ½ Σ xi_ij (B_ij − B⁰_ij)², f = −Σ L_ijᵀ A β_ij n",
              .source = "the gradient of Wu & Melo (18) with the terms that (19) drops")
