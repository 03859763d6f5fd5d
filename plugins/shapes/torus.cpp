#include <cmath>
#include <numbers>

#include <deform/surface/shape.h>

namespace {
using namespace deform;

struct Parameters {
  double radius = 1, tube = 0.3;
  Vec3 origin = Vec3::Zero();
  static void declare(Declaration<Parameters>& d) {
    d("radius", &Parameters::radius, "m", "of the circle in the middle of the tube")
        .required()
        .above(0);
    d("tube", &Parameters::tube, "m", "radius of the tube, less than 'radius'").required().above(0);
    d("origin", &Parameters::origin, "m", "the torus' centre");
  }
};

/// The parameter rectangle, once around both ways: a1 along the ring, from x towards y, a2 around
/// the tube, from the outside upwards. Closes where both parameters are periodic. n points
/// outwards.
class Torus final : public Shape {
 public:
  Torus(const Parameters& p, const Setup& /*setup*/) : p_(p) {
    if (p.tube >= p.radius)
      throw InputError({Problem{"/tube", "the tube of radius " + std::to_string(p.tube) +
                                             " m meets itself: it must be thinner than the ring's "
                                             "radius of " +
                                             std::to_string(p.radius) + " m"}});
  }

  [[nodiscard]] NodeVectors positions(const Eigen::MatrixX2d& parameters,
                                      const Vec2& size) const override {
    NodeVectors r(parameters.rows(), 3);
    for (Index a = 0; a < r.rows(); ++a) {
      const double u = 2 * std::numbers::pi * parameters(a, 0) / size[0],
                   v = 2 * std::numbers::pi * parameters(a, 1) / size[1];
      const double from_axis = p_.radius + p_.tube * std::cos(v);
      r.row(a) =
          p_.origin + Vec3(from_axis * std::cos(u), from_axis * std::sin(u), p_.tube * std::sin(v));
    }
    return r;
  }

 private:
  Parameters p_;
};

}  // namespace

DEFORM_PLUGIN(Torus, Parameters, .name = "torus", .version = "1.0",
              .summary = "a torus, closed both ways where both parameters are periodic",
              .formula =
                  "r = ((R + t cos v) cos u, (R + t cos v) sin u, t sin v), u = 2π a1/L1, "
                  "v = 2π a2/L2",
              .source = "")
