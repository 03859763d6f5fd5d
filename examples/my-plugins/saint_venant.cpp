// The membrane of Saint-Venant and Kirchhoff in plane stress. Where `stretching` weighs the
// components of G − G⁰ one by one, this one knows no direction, and has Poisson's effect. It gives
// its energy alone: its force is then a numerical derivative, which the log says.
#include <deform/model/energy_term.h>

namespace {
using namespace deform;

struct Parameters {
  double stiffness = 10, poisson = 0.3;
  static void declare(Declaration<Parameters>& d) {
    d("stiffness", &Parameters::stiffness, "N/m", "Young's modulus times thickness").at_least(0);
    d("poisson", &Parameters::poisson, "1", "Poisson's ratio").at_least(0).at_most(0.5);
  }
};

class SaintVenant final : public JetTerm {
 public:
  SaintVenant(const Parameters& p, const Setup& /*setup*/) : Y_(p.stiffness), nu_(p.poisson) {}

  [[nodiscard]] TermTraits traits() const override { return {.potential = true}; }
  [[nodiscard]] SampleRole role() const override { return SampleRole::membrane; }

  void energy_density(const SampleBlock& block, Values density) const override {
    const auto matrix = [](double t_11, double t_12, double t_22) {
      return (Eigen::Matrix2d() << t_11, t_12, t_12, t_22).finished();
    };
    const GeometryBlock &now = block.now, &rest = block.rest;
    for (std::size_t s = 0; s < density.size(); ++s) {
      const auto G = matrix(now.G(Pair::p11)[s], now.G(Pair::p12)[s], now.G(Pair::p22)[s]);
      const auto inverse = matrix(rest.reciprocal(Pair::p11)[s], rest.reciprocal(Pair::p12)[s],
                                  rest.reciprocal(Pair::p22)[s]);
      const Eigen::Matrix2d E =
          0.5 * (inverse * G - Eigen::Matrix2d::Identity());  // Green's strain
      const double w = (1 - nu_) * (E * E).trace() + nu_ * E.trace() * E.trace();
      density[s] += 0.5 * Y_ / (1 - nu_ * nu_) * w * rest.area_element()[s];
    }
  }

 private:
  double Y_, nu_;
};
}  // namespace

DEFORM_PLUGIN(SaintVenant, Parameters, .name = "saint_venant", .version = "1.0",
              .summary = "membrane of Saint-Venant and Kirchhoff in plane stress",
              .formula = "w = Y/(2(1 − ν²)) ((1 − ν) tr E² + ν (tr E)²), E = ½ (G⁰⁻¹ G − 1)")
