#include <deform/model/plate_term.h>
#include <deform/surface/surface.h>

namespace {
using namespace deform;

struct Parameters {
  double xi = 1e-6;
  double poisson = 0.3;
  static void declare(Declaration<Parameters>& d) {
    d("xi", &Parameters::xi, "N·m", "bending rigidity D").at_least(0);
    d("poisson", &Parameters::poisson, "1", "Poisson's ratio").at_least(0).at_most(0.5);
  }
};

/// With tr(M²) and tr(M) of M = G⁰⁻¹ u_;ij: ½ D √det G⁰ [(1 − ν) tr(M²) + ν tr(M)²], which is the
/// density below, as det M = (tr(M)² − tr(M²))/2.
class ThinPlate final : public PlateTerm {
 public:
  ThinPlate(const Parameters& p, const Setup& setup)
      : PlateTerm(setup.surface(), setup.rest(), Twist::separate),
        half_D_(
            NodeValues::Constant(setup.surface().samples(SampleRole::bending).size(), 0.5 * p.xi)),
        nu_(p.poisson) {}

  void stiffness(const GeometryBlock& rest, FormStiffness& c) const override {
    c.set_isotropic(rest, half_D_.data() + rest.first(), nu_);
  }

 private:
  NodeValues half_D_;
  double nu_;
};

}  // namespace

DEFORM_PLUGIN(
    ThinPlate, Parameters, .name = "thin_plate", .version = "1.1",
    .summary = "linear thin plate: quadratic bending, for flat sheets that fold or deflect little",
    .formula =
        "w = ½ D (|tr u_;ij|² − 2(1 − ν) det u_;ij) per rest area, u = r − r⁰, with covariant "
        "derivatives on the rest surface; |u_11 + u_22|² − 2(1 − ν)(u_11·u_22 − |u_12|²) where a1 "
        "and a2 are lengths",
    .source =
        "Kirchhoff 1850; Timoshenko & Woinowsky-Krieger, Theory of Plates and Shells; "
        "Bergou et al. 2006")
