#include <cmath>
#include <numbers>

#include <deform/surface/shape.h>

namespace {
using namespace deform;

struct Parameters {
  double radius = 1;
  std::string base = "corners";
  Vec3 origin = Vec3::Zero();
  static void declare(Declaration<Parameters>& d) {
    d("radius", &Parameters::radius, "m", "radius of the sphere").required().above(0);
    d("base", &Parameters::base, "", "what lies at height 0").one_of({"corners", "apex", "centre"});
    d("origin", &Parameters::origin, "m", "is added to every position");
  }
};

/// Longitude and latitude on a sphere, with the equator through the middle of the patch: a1 is the
/// arc length along the equator, a2 along the meridians. The apex is above the middle of the flat
/// sheet. No sphere is flat, so that G_11 = cos² v < 1 away from the equator.
class SpherePatch final : public Shape {
 public:
  SpherePatch(const Parameters& p, const Setup& /*setup*/)
      : radius_(p.radius), base_(p.base), origin_(p.origin) {}

  [[nodiscard]] NodeVectors positions(const Eigen::MatrixX2d& parameters,
                                      const Vec2& size) const override {
    const Vec2 half = size / (2 * radius_);  // [rad]
    if (half[0] > std::numbers::pi * (1 + kRounding))
      throw InputError(too_large("a1", size[0], "the equator"));
    if (half[1] >= std::numbers::pi / 2)
      throw InputError(
          too_large("a2", size[1], "a meridian, where the poles do not belong to the patch"));
    const double base = base_ == "corners" ? std::cos(half[1]) * std::cos(half[0])
                        : base_ == "apex"  ? 1
                                           : 0;
    NodeVectors r(parameters.rows(), 3);
    for (Index a = 0; a < r.rows(); ++a) {
      const double u = parameters(a, 0) / radius_ - half[0],
                   v = parameters(a, 1) / radius_ - half[1];
      r(a, 0) = size[0] / 2 + radius_ * std::cos(v) * std::sin(u);
      r(a, 1) = size[1] / 2 + radius_ * std::sin(v);
      r(a, 2) = radius_ * (std::cos(v) * std::cos(u) - base);
    }
    r.rowwise() += origin_.transpose();
    return r;
  }

 private:
  static constexpr double kRounding = 1e-9;  // of a radius that was written as a decimal number

  [[nodiscard]] std::string too_large(const char* axis, double length, const char* line) const {
    return "the surface is " + std::to_string(length) + " m long in " + axis + ": more than " +
           line + " of a sphere of radius " + std::to_string(radius_) + " m";
  }

  double radius_;
  std::string base_;
  Vec3 origin_;
};

}  // namespace

DEFORM_PLUGIN(SpherePatch, Parameters, .name = "sphere_patch", .version = "1.0",
              .summary = "part of a sphere, by longitude and latitude",
              .formula =
                  "r = (L1/2 + R cos v sin u, L2/2 + R sin v, R (cos v cos u − base)), "
                  "u = (a1 − L1/2)/R, v = (a2 − L2/2)/R",
              .source = "")
