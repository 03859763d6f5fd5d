#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include <deform/model/materials.h>
#include <deform/model/plate_term.h>
#include <deform/model/quadratic_term.h>
#include <deform/plugin/field.h>
#include <deform/surface/surface.h>

namespace {
using namespace deform;

constexpr double kNotGiven = std::numeric_limits<double>::quiet_NaN();

struct Parameters {
  std::string material = "none";
  Field young = kNotGiven;
  double poisson = kNotGiven;
  Field thickness = kNotGiven;
  std::string bending = "curvature";
  static void declare(Declaration<Parameters>& d) {
    std::vector<std::string> names = sheet_material_names();
    names.insert(names.begin(), "none");
    d("material", &Parameters::material, "",
      "sheet whose values hold where the scene gives none, its mass included")
        .one_of(names);
    d("young", &Parameters::young, "Pa", "Young's modulus; the material's when absent")
        .at_least(0)
        .optional();
    d("poisson", &Parameters::poisson, "1", "Poisson's ratio; the material's when absent")
        .above(-1)
        .at_most(0.5)
        .optional();
    d("thickness", &Parameters::thickness, "m", "of the sheet; the material's when absent")
        .at_least(0)
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
  const auto is_absent = [](const Field& f) { return f.is_constant() && std::isnan(f.constant()); };
  if (p.material != "none") {
    const SheetMaterial& sheet = sheet_material(p.material);
    if (is_absent(p.young)) p.young = sheet.young;
    if (is_absent(p.thickness)) p.thickness = sheet.thickness;
    if (std::isnan(p.poisson)) p.poisson = sheet.poisson;
  }
  const auto require = [](bool is_there, const std::string& name) {
    if (!is_there) throw InputError("'" + name + "' is missing: give it, or a 'material'");
  };
  require(!is_absent(p.young), "young");
  require(!is_absent(p.thickness), "thickness");
  require(!std::isnan(p.poisson), "poisson");
  const auto require_some = [](const Field& f, const std::string& name) {
    if (f.is_constant() && f.constant() == 0)
      throw InputError("'" + name + "' is 0, expected more than 0");
  };
  require_some(p.young, "young");
  require_some(p.thickness, "thickness");
  return p;
}

/// factor · √det G⁰ [(1 − ν) tr(M²) + ν tr(M)²] with M = G⁰⁻¹ X, as a quadratic form of X, which
/// Term (a QuadraticTerm or a PlateTerm, made of `of`) defines.
template <class Term>
class Isotropic final : public Term {
 public:
  /// `factor`: one number a sample of the term's set [N/m or N·m].
  template <class... Of>
  Isotropic(NodeValues factor, double nu, const Of&... of)
      : Term(of...), factor_(std::move(factor)), nu_(nu) {}

  void stiffness(const GeometryBlock& rest, FormStiffness& c) const override {
    c.set_isotropic(rest, factor_.data() + rest.first(), nu_);
  }

 private:
  NodeValues factor_;
  double nu_;
};

/// W = E h/(8(1−ν²)) […in G − G⁰] + E h³/(24(1−ν²)) […in B − B⁰ or r_;ij] per rest area.
class Koiter final : public CompoundTerm {
 public:
  Koiter(const Parameters& given, const Setup& setup) {
    const Parameters p = completed(given);
    const Surface& surface = setup.surface();
    const double plane = 1 - p.poisson * p.poisson;
    if (p.material != "none")
      mass_ = p.thickness.at_nodes(surface).unaryExpr(
          [&sheet = sheet_material(p.material)](double h) { return sheet.mass_per_area(h); });
    const auto at = [&](const Field& field, SampleRole role) {
      return field.at_samples(surface, surface.samples(role)).array().eval();
    };
    const NodeValues stretching =
        at(p.young, SampleRole::membrane) * at(p.thickness, SampleRole::membrane) / (8 * plane);
    const NodeValues bending = at(p.young, SampleRole::bending) *
                               at(p.thickness, SampleRole::bending).cube() / (24 * plane);
    const auto plate = [&]() -> std::shared_ptr<EnergyTerm> {
      require_flat(setup);
      return std::make_shared<Isotropic<PlateTerm>>(bending, p.poisson, surface, setup.rest(),
                                                    PlateTerm::Twist::separate);
    };
    parts_ = {{"stretching",
               std::make_shared<Isotropic<QuadraticTerm>>(stretching, p.poisson, Form::metric)},
              {"bending", p.bending == "isometric" ? plate()
                                                   : std::make_shared<Isotropic<QuadraticTerm>>(
                                                         bending, p.poisson, Form::curvature)}};
  }
  [[nodiscard]] const std::vector<Part>& parts() const override { return parts_; }
  [[nodiscard]] NodeValues mass_per_area() const override { return mass_; }

 private:
  std::vector<Part> parts_;
  NodeValues mass_;
};

}  // namespace

DEFORM_PLUGIN(Koiter, Parameters, .name = "koiter", .version = "1.1",
              .summary = "thin shell of an isotropic St. Venant–Kirchhoff material",
              .formula =
                  "W = E h/(8(1−ν²)) [(1−ν) tr(M²) + ν tr(M)²] + E h³/(24(1−ν²)) [in S, or of the "
                  "vectors r_;ij]",
              .source = "Koiter 1966; Ciarlet 2005; isometric: Bergou et al. 2006")
