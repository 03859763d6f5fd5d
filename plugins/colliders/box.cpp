#include <deform/model/collider.h>
#include <deform/plugin/setup.h>

namespace {
using namespace deform;

struct Parameters {
  Vec3 centre{0, 0, -0.5}, size = Vec3::Ones();
  double rounding = 0;
  static void declare(Declaration<Parameters>& d) {
    d("centre", &Parameters::centre, "m", "of the box");
    d("size", &Parameters::size, "m", "whole lengths along x, y and z").above(0);
    d("rounding", &Parameters::rounding, "m", "radius of the edges, at most half of the least size")
        .at_least(0);
  }
};

/// A box along the axes.
class Box final : public Collider {
 public:
  Box(const Parameters& p, const Setup& /*setup*/) : p_(p) {
    if (p.rounding > 0.5 * p.size.minCoeff())
      throw InputError("rounding is more than half of the least size");
  }
  void measure(double /*time*/, ConstVectors points, Values distance,
               Vectors normal) const override {
    measure_each(points, distance, normal, [this](const Vec3& p) {
      SignedDistance d;
      d.distance = rounded_box_distance<Vec3>(p - p_.centre, 0.5 * p_.size, p_.rounding, d.normal);
      return d;
    });
  }
  [[nodiscard]] bool is_convex() const override { return true; }

 private:
  Parameters p_;
};

}  // namespace

DEFORM_PLUGIN(Box, Parameters, .name = "box", .version = "1.0",
              .summary = "a box along the axes, with rounded edges",
              .formula =
                  "φ(p) = |max(q, 0)| + min(max(q_x, q_y, q_z), 0) − ρ, q = |p − centre| − "
                  "size/2 + ρ")
