#include <cmath>
#include <numbers>

#include <deform/surface/shape.h>

namespace {
using namespace deform;

struct Parameters {
  double radius = 1, hole = 18, sector = 360;
  Vec3 origin = Vec3::Zero();
  static void declare(Declaration<Parameters>& d) {
    d("radius", &Parameters::radius, "m", "radius of the sphere").required().above(0);
    d("hole", &Parameters::hole, "deg",
      "angle at the centre between the pole and the rim of the hole around it; not 0, because all "
      "meridians meet at the pole: it has no metric")
        .above(0)
        .at_most(89);
    d("sector", &Parameters::sector, "deg", "of longitude; 360 closes where a1 is periodic")
        .above(0)
        .at_most(360);
    d("origin", &Parameters::origin, "m", "the sphere's centre");
  }
};

/// The whole parameter rectangle on the upper half of a sphere without its pole: a1 is the
/// longitude, from x towards y, a2 the latitude, from the equator to the hole. n points outwards.
class Hemisphere final : public Shape {
 public:
  Hemisphere(const Parameters& p, const Setup& /*setup*/) : p_(p) {}

  [[nodiscard]] NodeVectors positions(const Eigen::MatrixX2d& parameters,
                                      const Vec2& size) const override {
    constexpr double degree = std::numbers::pi / 180;
    NodeVectors r(parameters.rows(), 3);
    for (Index a = 0; a < r.rows(); ++a) {
      const double u = p_.sector * degree * parameters(a, 0) / size[0],
                   v = (90 - p_.hole) * degree * parameters(a, 1) / size[1];
      r.row(a) = p_.origin + p_.radius * Vec3(std::cos(v) * std::cos(u), std::cos(v) * std::sin(u),
                                              std::sin(v));
    }
    return r;
  }

 private:
  Parameters p_;
};

}  // namespace

DEFORM_PLUGIN(Hemisphere, Parameters, .name = "hemisphere", .version = "1.0",
              .summary = "half a sphere, or a sector of it, with a hole at the pole",
              .formula =
                  "r = R (cos v cos u, cos v sin u, sin v), u = sector a1/L1, v = (90° − hole) "
                  "a2/L2",
              .source = "")
