#include "deform/check/known_surfaces.h"

#include <cmath>
#include <numbers>

namespace deform {
namespace {

/// Graph of a function z(x, y) with its slopes.
KnownSurface graph(const std::string& name, const std::function<double(double, double)>& z,
                   const std::function<Vec2(double, double)>& slope) {
  return {name, [z](double x, double y) { return Vec3(x, y, z(x, y)); },
          [slope](double x, double y) {
            const Vec2 s = slope(x, y);
            return Vec3(-s.x(), -s.y(), 1).normalized();
          }};
}

}  // namespace

std::vector<KnownSurface> known_surfaces() {
  const double R = 1 / 1.2;  // a patch of 1.2 rad a side
  const auto sphere_normal = [R](double u, double v) {
    const double p = (u - .5) / R, q = (v - .5) / R;
    return Vec3(std::sin(p) * std::cos(q), std::sin(q), std::cos(p) * std::cos(q));
  };
  const auto cylinder = [R](double angle, double v) {
    return Vec3(R * std::sin(angle), v, R * std::cos(angle));
  };
  const auto uneven = [](double u) {
    return 1.4 * (u + 0.15 * std::sin(2 * std::numbers::pi * u));
  };
  return {
      {"sphere patch", [=](double u, double v) -> Vec3 { return R * sphere_normal(u, v); },
       sphere_normal},
      {"cylinder", [=](double u, double v) { return cylinder(u / R, v); },
       [=](double u, double) { return Vec3(std::sin(u / R), 0, std::cos(u / R)); }},
      {"uneven cylinder", [=](double u, double v) { return cylinder(uneven(u), v); },
       [=](double u, double) { return Vec3(std::sin(uneven(u)), 0, std::cos(uneven(u))); }},
      graph(
          "paraboloid", [](double x, double y) { return .5 * x * x + .8 * y * y + .3 * x * y; },
          [](double x, double y) { return Vec2(x + .3 * y, 1.6 * y + .3 * x); }),
      graph(
          "saddle", [](double x, double y) { return .7 * (x * x - y * y) + .4 * x * x * x * y; },
          [](double x, double y) {
            return Vec2(1.4 * x + 1.2 * x * x * y, -1.4 * y + .4 * x * x * x);
          })};
}

double angle(const Vec3& a, const Vec3& b) { return std::atan2(a.cross(b).norm(), a.dot(b)); }

}  // namespace deform
