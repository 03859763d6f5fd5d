#include <cmath>
#include <numbers>

#include <deform/surface/shape.h>

namespace {
using namespace deform;

struct Parameters {
  double inner = 0, turns = 1, height = 1;
  Vec3 origin = Vec3::Zero();
  static void declare(Declaration<Parameters>& d) {
    d("inner", &Parameters::inner, "m",
      "distance of the side a1 = 0 from the axis; negative: the sheet reaches across the axis");
    d("turns", &Parameters::turns, "1",
      "around the axis, from a2 = 0 to its end; negative: "
      "left-handed");
    d("height", &Parameters::height, "m", "along the axis, from a2 = 0 to its end")
        .required()
        .above(0);
    d("origin", &Parameters::origin, "m", "where the axis is at a2 = 0");
  }
};

/// A spiral staircase, or a twisted strip: a1 is the length along the straight lines across, a2
/// runs along the axis, which is parallel to z. A minimal surface: its mean curvature is 0.
class Helicoid final : public Shape {
 public:
  Helicoid(const Parameters& p, const Setup& /*setup*/) : p_(p) {}

  [[nodiscard]] NodeVectors positions(const Eigen::MatrixX2d& parameters,
                                      const Vec2& size) const override {
    NodeVectors r(parameters.rows(), 3);
    for (Index a = 0; a < r.rows(); ++a) {
      const double along = parameters(a, 1) / size[1], from_axis = p_.inner + parameters(a, 0),
                   u = 2 * std::numbers::pi * p_.turns * along;
      r.row(a) =
          p_.origin + Vec3(from_axis * std::cos(u), from_axis * std::sin(u), p_.height * along);
    }
    return r;
  }

 private:
  Parameters p_;
};

}  // namespace

DEFORM_PLUGIN(Helicoid, Parameters, .name = "helicoid", .version = "1.0",
              .summary = "a strip twisted around an axis, or a spiral staircase",
              .formula = "r = (ρ cos u, ρ sin u, H a2/L2), ρ = inner + a1, u = 2π turns a2/L2",
              .source = "")
