#include <deform/model/collider.h>
#include <deform/plugin/setup.h>

namespace {
using namespace deform;

struct Parameters {
  Vec3 centre{0, 0, -0.5}, axis = Vec3::UnitZ();
  double radius = 1, height = 1, rounding = 0;
  static void declare(Declaration<Parameters>& d) {
    d("centre", &Parameters::centre, "m", "half-way along the axis");
    d("axis", &Parameters::axis, "", "direction, of any length but 0");
    d("radius", &Parameters::radius, "m", "about the axis").above(0);
    d("height", &Parameters::height, "m", "along the axis").above(0);
    d("rounding", &Parameters::rounding, "m",
      "radius of the two edges, at most the cylinder's and half of its height")
        .at_least(0);
  }
};

/// A solid cylinder: a rounded box in the plane of distance from and along the axis.
class Cylinder final : public Collider {
 public:
  Cylinder(const Parameters& p, const Setup& /*setup*/) : p_(p), axis_(p.axis.normalized()) {
    if (!(p.axis.norm() > 0)) throw InputError("axis is 0, expected a direction");
    if (p.rounding > std::min(p.radius, 0.5 * p.height))
      throw InputError("rounding is more than the radius or half of the height");
  }
  void measure(double /*time*/, ConstVectors points, Values distance,
               Vectors normal) const override {
    measure_each(points, distance, normal, [this](const Vec3& p) {
      const Vec3 d = p - p_.centre;
      const double along = d.dot(axis_);
      const Vec3 across = d - along * axis_;
      const double from_axis = across.norm();
      // On the axis every direction away from it is as good as another.
      const Vec3 outwards = from_axis > 0 ? Vec3(across / from_axis) : axis_.unitOrthogonal();
      Vec2 gradient;
      SignedDistance result;
      result.distance = rounded_box_distance<Vec2>({from_axis, along}, {p_.radius, 0.5 * p_.height},
                                                   p_.rounding, gradient);
      result.normal = gradient.x() * outwards + gradient.y() * axis_;
      return result;
    });
  }
  [[nodiscard]] bool is_convex() const override { return true; }

 private:
  Parameters p_;
  Vec3 axis_;
};

}  // namespace

DEFORM_PLUGIN(Cylinder, Parameters, .name = "cylinder", .version = "1.0",
              .summary = "a solid cylinder with rounded edges",
              .formula =
                  "φ(p) = |max(q, 0)| + min(max(q), 0) − ρ, q = (|p⊥| − radius + ρ, |p∥| − "
                  "height/2 + ρ)")
