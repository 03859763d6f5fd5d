#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include <deform/model/materials.h>
#include <deform/model/plate_term.h>
#include <deform/model/quadratic_term.h>
#include <deform/surface/surface.h>

namespace {
using namespace deform;

constexpr double kNotGiven = std::numeric_limits<double>::quiet_NaN();

struct Parameters {
  std::string material = "none";
  double young_1 = kNotGiven, young_2 = kNotGiven, shear = kNotGiven, poisson = kNotGiven,
         thickness = kNotGiven;
  std::string bending = "curvature";
  static void declare(Declaration<Parameters>& d) {
    std::vector<std::string> names{"none"};
    for (const SheetMaterial& sheet : sheet_materials())
      if (sheet.directions) names.push_back(sheet.name);
    d("material", &Parameters::material, "",
      "sheet whose values hold where the scene gives none, its mass included")
        .one_of(names);
    d("young_1", &Parameters::young_1, "Pa",
      "Young's modulus along a1 (warp, machine direction); the material's when absent")
        .above(0)
        .optional();
    d("young_2", &Parameters::young_2, "Pa",
      "Young's modulus across it (weft, cross direction); the material's when absent")
        .above(0)
        .optional();
    d("shear", &Parameters::shear, "Pa", "shear modulus in the sheet; the material's when absent")
        .above(0)
        .optional();
    d("poisson", &Parameters::poisson, "1",
      "contraction across, of a pull along a1; the material's when absent")
        .at_least(-1)
        .at_most(2)
        .optional();
    d("thickness", &Parameters::thickness, "m", "of the sheet; the material's when absent")
        .above(0)
        .optional();
    d("bending", &Parameters::bending, "",
      "\"curvature\": in B − B⁰, for any shape; \"isometric\": in the second derivatives of r, "
      "which "
      "is the same where a flat sheet bends without stretching, smooth where cloth folds more "
      "sharply than its grid resolves, and constant in Newton's matrix")
        .one_of({"curvature", "isometric"});
  }
};

/// What the scene says, the material's values where it says nothing.
Parameters completed(Parameters p) {
  if (p.material != "none") {
    const SheetMaterial& sheet = sheet_material(p.material);
    if (std::isnan(p.young_1)) p.young_1 = sheet.directions->young_1;
    if (std::isnan(p.young_2)) p.young_2 = sheet.directions->young_2;
    if (std::isnan(p.shear)) p.shear = sheet.directions->shear;
    if (std::isnan(p.poisson)) p.poisson = sheet.poisson;
    if (std::isnan(p.thickness)) p.thickness = sheet.thickness;
  }
  const auto require = [](double value, const std::string& name) {
    if (std::isnan(value)) throw InputError("'" + name + "' is missing: give it, or a 'material'");
  };
  require(p.young_1, "young_1");
  require(p.young_2, "young_2");
  require(p.shear, "shear");
  require(p.poisson, "poisson");
  require(p.thickness, "thickness");
  if (!(p.poisson * p.poisson * p.young_2 < p.young_1))
    throw InputError("'poisson' is " + std::to_string(p.poisson) +
                     ": poisson² · young_2 < young_1 is what makes the energy positive");
  return p;
}

/// factor · √det G⁰ · x·Q x of the components x = (X'_11, X'_12, X'_22) of X along the orthonormal
/// frame e_1 ∥ r_1, e_2 of the rest surface; Term (a QuadraticTerm or a PlateTerm, made of `of`)
/// says what X is.
template <class Term>
class Orthotropic final : public Term {
 public:
  template <class... Of>
  Orthotropic(double factor, const Parameters& p, const Of&... of) : Term(of...) {
    const double poisson_2 = p.poisson * p.young_2 / p.young_1;
    const double plane = 1 - p.poisson * poisson_2;
    Q_ << p.young_1 / plane, 0, poisson_2 * p.young_1 / plane,  //
        0, 4 * p.shear, 0,                                      //
        poisson_2 * p.young_1 / plane, 0, p.young_2 / plane;
    Q_ *= 2 * factor;
  }

  void stiffness(const GeometryBlock& rest, FormStiffness& c) const override {
    for (Index s = 0; s < rest.size(); ++s) {
      const auto i = static_cast<std::size_t>(s);
      const double G_11 = rest.G(Pair::p11)[i], G_12 = rest.G(Pair::p12)[i];
      const double area = rest.area_element()[i];
      if (!(area > 0)) {  // a border where the tangents do not exist
        c.set(s, Eigen::Matrix3d::Zero());
        continue;
      }
      // e_1 = f_1 r_1, e_2 = g_1 r_1 + g_2 r_2.
      const double f_1 = 1 / std::sqrt(G_11), g_2 = std::sqrt(G_11) / area,
                   g_1 = -G_12 / G_11 * g_2;
      Eigen::Matrix3d P;
      P << f_1 * f_1, 0, 0,         //
          f_1 * g_1, f_1 * g_2, 0,  //
          g_1 * g_1, 2 * g_1 * g_2, g_2 * g_2;
      c.set(s, area * P.transpose() * Q_ * P);
    }
  }

 private:
  Eigen::Matrix3d Q_;
};

/// W = h/8 [Q_11 X_11² + 2 Q_12 X_11 X_22 + Q_22 X_22² + 4 G X_12²] in X = G − G⁰ and h³/24 [the
/// same] in X = B − B⁰ or r_;ij, per rest area.
class KoiterOrthotropic final : public CompoundTerm {
 public:
  KoiterOrthotropic(const Parameters& given, const Setup& setup) {
    const Parameters p = completed(given);
    require_chart(setup.surface(), "a material with two directions");
    const double h = p.thickness;
    if (p.material != "none")
      mass_ = NodeValues::Constant(setup.surface().nodes(),
                                   sheet_material(p.material).mass_per_area(h));
    const double bending = h * h * h / 24;
    const auto plate = [&]() -> std::shared_ptr<EnergyTerm> {
      require_flat(setup);
      return std::make_shared<Orthotropic<PlateTerm>>(bending, p, setup.surface(), setup.rest(),
                                                      PlateTerm::Twist::separate);
    };
    parts_ = {{"stretching", std::make_shared<Orthotropic<QuadraticTerm>>(h / 8, p, Form::metric)},
              {"bending", p.bending == "isometric" ? plate()
                                                   : std::make_shared<Orthotropic<QuadraticTerm>>(
                                                         bending, p, Form::curvature)}};
  }
  [[nodiscard]] const std::vector<Part>& parts() const override { return parts_; }
  [[nodiscard]] NodeValues mass_per_area() const override { return mass_; }

 private:
  std::vector<Part> parts_;
  NodeValues mass_;
};

}  // namespace

DEFORM_PLUGIN(KoiterOrthotropic, Parameters, .name = "koiter_orthotropic", .version = "1.1",
              .summary = "thin shell of a material with two directions: woven cloth, paper",
              .formula =
                  "W = h/8 [Q_11 X_11² + 2 Q_12 X_11 X_22 + Q_22 X_22² + 4 G X_12²] in G − G⁰ "
                  "+ h³/24 […] in B − B⁰, or of the vectors r_;ij",
              .source = "Koiter 1966; Jones, Mechanics of Composite Materials, chapter 2")
