#include <cmath>
#include <numbers>

#include <deform/surface/shape.h>

namespace {
using namespace deform;

struct Parameters {
  double radius = 1;
  int along = 1;
  int side = 1;
  std::string base = "ends";
  Vec3 origin = Vec3::Zero();
  static void declare(Declaration<Parameters>& d) {
    d("radius", &Parameters::radius, "m", "radius of the cylinder").required().above(0);
    d("along", &Parameters::along, "", "the parameter, 1 or 2, that runs around the cylinder")
        .at_least(1)
        .at_most(2);
    d("side", &Parameters::side, "", "1: arched upwards, B = −1/radius; -1: hanging, B = 1/radius")
        .at_least(-1)
        .at_most(1);
    d("base", &Parameters::base, "", "what lies at height 0").one_of({"ends", "apex", "axis"});
    d("origin", &Parameters::origin, "m", "is added to every position");
  }
};

/// A sheet bent around a cylinder without stretching: the arc length is the parameter. Its middle
/// is above (or below) that of the flat sheet. A whole circle is the most; periodic surfaces close
/// it to a tube.
class Arc final : public Shape {
 public:
  Arc(const Parameters& p, const Setup& /*setup*/)
      : radius_(p.radius), along_(p.along - 1), side_(p.side), base_(p.base), origin_(p.origin) {
    if (p.side == 0) throw InputError("'side' is 0: it must be 1 or -1");
  }

  [[nodiscard]] NodeVectors positions(const Eigen::MatrixX2d& parameters,
                                      const Vec2& size) const override {
    const double half = size[along_] / (2 * radius_);  // [rad]
    if (half > std::numbers::pi * (1 + kRounding))
      throw InputError("an arc of length " + std::to_string(size[along_]) +
                       " m goes more than once around a circle of radius " +
                       std::to_string(radius_) + " m");
    const double base = base_ == "ends" ? std::cos(half) : base_ == "apex" ? 1 : 0;
    NodeVectors r(parameters.rows(), 3);
    for (Index a = 0; a < r.rows(); ++a) {
      const double phi = parameters(a, along_) / radius_ - half;
      r(a, along_) = size[along_] / 2 + radius_ * std::sin(phi);
      r(a, 1 - along_) = parameters(a, 1 - along_);
      r(a, 2) = side_ * radius_ * (std::cos(phi) - base);
    }
    r.rowwise() += origin_.transpose();
    return r;
  }

 private:
  static constexpr double kRounding = 1e-9;  // of a radius that was written as a decimal number

  double radius_;
  Index along_;  // component that runs around
  int side_;
  std::string base_;
  Vec3 origin_;
};

}  // namespace

DEFORM_PLUGIN(
    Arc, Parameters, .name = "arc", .version = "1.0",
    .summary = "part of a cylinder, bent without stretching",
    .formula =
        "r = (L/2 + R sin φ, a2, ±R (cos φ − base)), φ = (a1 − L/2)/R; base = cos(L/2R), 1 or 0",
    .source = "")
