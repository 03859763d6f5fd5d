/// Surfaces whose jets are known in closed form, and integrals over them.
#pragma once

#include <array>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "deform/geometry/pairs.h"
#include "deform/types.h"

namespace deform::test {

/// r, r_1, r_2, r_11, r_12, r_22 at a place.
using Jet = std::array<Vec3, kDerivatives>;

struct Analytic {
  std::string name;
  std::function<Jet(double, double)> jet;  ///< at (a1, a2) of the unit square
};

inline Vec3 normal(const Jet& jet) { return jet[1].cross(jet[2]).normalized(); }
inline double metric(const Jet& jet, Pair ij) {
  const std::size_t i = ij == Pair::p22 ? 2 : 1, j = ij == Pair::p11 ? 1 : 2;
  return jet[i].dot(jet[j]);
}
inline double curvature(const Jet& jet, Pair ij) {
  return normal(jet).dot(jet[static_cast<std::size_t>(slot(second(ij)))]);
}

/// A patch of a sphere off its symmetry lines; a cylinder with an uneven parameter; a wave that is
/// stretched in its plane, too.
inline std::vector<Analytic> analytic_surfaces() {
  const auto sphere = [](double a, double b) -> Jet {
    const double R = 0.9, u = (a - 0.3) / R, v = (b - 0.4) / R;
    const double cu = std::cos(u), su = std::sin(u), cv = std::cos(v), sv = std::sin(v);
    return {Vec3(R * cv * su, R * sv, R * cv * cu), Vec3(cv * cu, 0, -cv * su),
            Vec3(-sv * su, cv, -sv * cu),           Vec3(-cv * su, 0, -cv * cu) / R,
            Vec3(-sv * cu, 0, sv * su) / R,         Vec3(-cv * su, -sv, -cv * cu) / R};
  };
  const auto cylinder = [](double a, double b) -> Jet {
    const double t = 1.4 * a + 0.2 * std::sin(3 * a), t_1 = 1.4 + 0.6 * std::cos(3 * a),
                 t_11 = -1.8 * std::sin(3 * a), c = std::cos(t), s = std::sin(t);
    return {Vec3(s, b + 0.2 * b * b, c),
            Vec3(c * t_1, 0, -s * t_1),
            Vec3(0, 1 + 0.4 * b, 0),
            Vec3(c * t_11 - s * t_1 * t_1, 0, -s * t_11 - c * t_1 * t_1),
            Vec3::Zero(),
            Vec3(0, 0.4, 0)};
  };
  const auto wave = [](double a, double b) -> Jet {
    const double p = 3 * a + 1, q = 2 * b + 0.5, A = 0.15;
    const double sp = std::sin(p), cp = std::cos(p), sq = std::sin(q), cq = std::cos(q);
    return {Vec3(a + 0.05 * sq, b + 0.1 * sp, A * sp * cq),
            Vec3(1, 0.3 * cp, 3 * A * cp * cq),
            Vec3(0.1 * cq, 1, -2 * A * sp * sq),
            Vec3(0, -0.9 * sp, -9 * A * sp * cq),
            Vec3(0, 0, -6 * A * cp * sq),
            Vec3(-0.2 * sq, 0, -4 * A * sp * cq)};
  };
  return {{"sphere", sphere}, {"uneven cylinder", cylinder}, {"wave", wave}};
}

/// ∫ density da over the unit square, to rounding for smooth densities: Gauss' rule with five
/// points on 16 × 16 panels.
inline double integral(const std::function<double(double, double)>& density) {
  constexpr std::array<std::pair<double, double>, 5> kRule{
      {{0, 128.0 / 225},
       {0.5384693101056831, 0.4786286704993665},
       {-0.5384693101056831, 0.4786286704993665},
       {0.9061798459386640, 0.2369268850561891},
       {-0.9061798459386640, 0.2369268850561891}}};
  constexpr int kPanels = 16;
  double sum = 0;
  for (int i = 0; i < kPanels; ++i)
    for (int j = 0; j < kPanels; ++j)
      for (const auto& [x, w_x] : kRule)
        for (const auto& [y, w_y] : kRule)
          sum += w_x * w_y * density((i + 0.5 + x / 2) / kPanels, (j + 0.5 + y / 2) / kPanels);
  return sum / (4.0 * kPanels * kPanels);
}

}  // namespace deform::test
