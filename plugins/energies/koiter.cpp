#include <cmath>

#include <deform/model/quadratic_term.h>

namespace {
using namespace deform;

struct Parameters {
  double young = 1e6;
  double poisson = 0.3;
  double thickness = 1e-3;
  static void declare(Declaration<Parameters>& d) {
    d("young", &Parameters::young, "Pa", "Young's modulus").required().above(0);
    d("poisson", &Parameters::poisson, "1", "Poisson's ratio").at_least(0).at_most(0.5);
    d("thickness", &Parameters::thickness, "m", "of the sheet").required().above(0);
  }
};

/// factor · √det G⁰ [(1 − ν) tr(M²) + ν tr(M)²] with M = G⁰⁻¹ X, as a quadratic form of X.
class IsotropicTerm final : public QuadraticTerm {
 public:
  IsotropicTerm(Form form, double factor, double nu)
      : QuadraticTerm(form), factor_(factor), nu_(nu) {}

  void stiffness(const GeometryBlock& rest, FormStiffness& c) const override {
    for (Index s = 0; s < rest.size(); ++s) {
      const auto i = static_cast<std::size_t>(s);
      const double g11 = rest.reciprocal(Pair::p11)[i], g12 = rest.reciprocal(Pair::p12)[i],
                   g22 = rest.reciprocal(Pair::p22)[i];
      Eigen::Matrix3d A;  // of tr(M²)
      A << g11 * g11, 2 * g11 * g12, g12 * g12,                   //
          2 * g11 * g12, 2 * (g11 * g22 + g12 * g12), 2 * g12 * g22,  //
          g12 * g12, 2 * g12 * g22, g22 * g22;
      const Vec3 v(g11, 2 * g12, g22);  // tr(M) = v·X
      c.set(s, 2 * factor_ * rest.area_element()[i] * ((1 - nu_) * A + nu_ * v * v.transpose()));
    }
  }

 private:
  double factor_, nu_;
};

/// W = E h/(8(1−ν²)) […in G − G⁰] + E h³/(24(1−ν²)) […in B − B⁰] per rest area.
class Koiter final : public CompoundTerm {
 public:
  Koiter(const Parameters& p, const Setup& /*setup*/) {
    const double plane = p.young * p.thickness / (1 - p.poisson * p.poisson);
    parts_ = {{"stretching", std::make_shared<IsotropicTerm>(Form::metric, plane / 8, p.poisson)},
              {"bending", std::make_shared<IsotropicTerm>(
                              Form::curvature, plane * p.thickness * p.thickness / 24, p.poisson)}};
  }
  [[nodiscard]] const std::vector<Part>& parts() const override { return parts_; }

 private:
  std::vector<Part> parts_;
};

}  // namespace

DEFORM_PLUGIN(Koiter, Parameters, .name = "koiter", .version = "1.0",
              .summary = "thin shell of an isotropic St. Venant–Kirchhoff material",
              .formula = "W = E h/(8(1−ν²)) [(1−ν) tr(M²) + ν tr(M)²] + E h³/(24(1−ν²)) [in S]",
              .source = "Koiter 1966; Ciarlet 2005")
