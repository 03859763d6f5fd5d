#include <deform/model/quadratic_term.h>

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
class Stretching final : public QuadraticTerm {
 public:
  Stretching(const Parameters& p, const Setup& /*setup*/)
      : QuadraticTerm(Form::metric), c_(weighted_norm_stiffness(0.25, p.eta)) {}

  [[nodiscard]] bool is_diagonal() const override { return true; }
  void stiffness(const GeometryBlock& rest, FormStiffness& c) const override {
    for (Index s = 0; s < rest.size(); ++s) c.set(s, c_);
  }

 private:
  Eigen::Matrix3d c_;
};

}  // namespace

DEFORM_PLUGIN(Stretching, Parameters, .name = "stretching", .version = "1.0",
              .summary = "resistance to stretching and shearing",
              .formula = "w = ¼ Σ eta_ij (G_ij − G⁰_ij)²",
              .source = "Wu & Melo (19), (20), first part")
