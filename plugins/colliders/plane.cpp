#include <deform/model/collider.h>
#include <deform/plugin/setup.h>

namespace {
using namespace deform;

struct Parameters {
  Vec3 point = Vec3::Zero(), normal = Vec3::UnitZ();
  static void declare(Declaration<Parameters>& d) {
    d("point", &Parameters::point, "m", "of the plane");
    d("normal", &Parameters::normal, "", "away from the body; any length but 0");
  }
};

/// Everything behind a plane.
class Plane final : public Collider {
 public:
  Plane(const Parameters& p, const Setup& /*setup*/) : point_(p.point), n_(p.normal.normalized()) {
    if (!(p.normal.norm() > 0)) throw InputError("normal is 0, expected a direction");
  }
  void measure(double /*time*/, ConstVectors points, Values distance,
               Vectors normal) const override {
    measure_each(points, distance, normal, [this](const Vec3& p) {
      return SignedDistance{(p - point_).dot(n_), n_};
    });
  }
  [[nodiscard]] bool is_convex() const override { return true; }

 private:
  Vec3 point_, n_;
};

}  // namespace

DEFORM_PLUGIN(Plane, Parameters, .name = "plane", .version = "1.0",
              .summary = "everything behind a plane", .formula = "φ(p) = (p − point)·n")
