#include <deform/model/collider.h>
#include <deform/plugin/setup.h>

namespace {
using namespace deform;

struct Parameters {
  Vec3 centre{0, 0, -1};
  double radius = 1;
  static void declare(Declaration<Parameters>& d) {
    d("centre", &Parameters::centre, "m", "of the ball");
    d("radius", &Parameters::radius, "m", "of the ball").above(0);
  }
};

class Sphere final : public Collider {
 public:
  Sphere(const Parameters& p, const Setup& /*setup*/) : p_(p) {}
  void measure(double /*time*/, ConstVectors points, Values distance,
               Vectors normal) const override {
    measure_each(points, distance, normal, [this](const Vec3& p) {
      const Vec3 d = p - p_.centre;
      const double length = d.norm();
      // At the centre every direction is as good as another.
      return SignedDistance{length - p_.radius, length > 0 ? Vec3(d / length) : Vec3::UnitZ()};
    });
  }
  [[nodiscard]] bool is_convex() const override { return true; }

 private:
  Parameters p_;
};

}  // namespace

DEFORM_PLUGIN(Sphere, Parameters, .name = "sphere", .version = "1.0", .summary = "a ball",
              .formula = "φ(p) = |p − centre| − radius")
