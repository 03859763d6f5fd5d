#include <cmath>
#include <numbers>

#include <deform/error.h>
#include <deform/surface/shape.h>

namespace {
using namespace deform;

struct Parameters {
  double amplitude = 0.01, wavelength = 1.0;
  std::int64_t along = 1;
  Vec3 origin = Vec3::Zero();
  static void declare(Declaration<Parameters>& d) {
    d("amplitude", &Parameters::amplitude, "m", "height of a crest above the middle plane");
    d("wavelength", &Parameters::wavelength, "m", "from crest to crest").above(0);
    d("along", &Parameters::along, "", "parameter along which the wave runs, 1 or 2")
        .at_least(1)
        .at_most(2);
    d("origin", &Parameters::origin, "m", "where a1 = a2 = 0 is, less the wave");
  }
};

/// A flat sheet with a cosine in z: a start that is not exactly flat.
class Wave final : public Shape {
 public:
  Wave(const Parameters& p, const Setup& /*setup*/) : p_(p) {}

  [[nodiscard]] NodeVectors positions(const Eigen::MatrixX2d& parameters,
                                      const Vec2& /*size*/) const override {
    NodeVectors r(parameters.rows(), 3);
    for (Index a = 0; a < r.rows(); ++a) {
      const double phase = 2 * std::numbers::pi * parameters(a, p_.along - 1) / p_.wavelength;
      if (!std::isfinite(phase))
        throw InputError(
            "a wavelength so short that the number of waves on the surface is not finite");
      r.row(a) =
          p_.origin + Vec3(parameters(a, 0), parameters(a, 1), p_.amplitude * std::cos(phase));
    }
    return r;
  }

 private:
  Parameters p_;
};

}  // namespace

DEFORM_PLUGIN(Wave, Parameters, .name = "wave", .version = "1.0",
              .summary = "a flat sheet with a cosine wave in z",
              .formula = "r = (a1, a2, A cos(2π a/λ))", .source = "")
