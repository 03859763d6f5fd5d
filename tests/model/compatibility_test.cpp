/// The probe `compatibility`, residuals of the equations of Gauss and of Codazzi and Mainardi: on
/// smooth surfaces they vanish as fast as differences converge, and on a wave that nodes hardly
/// resolve they are known.
#include <cmath>
#include <numbers>
#include <string>

#include <fmt/format.h>

#include "deform/record/probe.h"

#include "model/support/simulate.h"

namespace deform {
namespace {

struct Residuals {
  double gauss = 0, codazzi = 0;  // [1/m²]
};

/// Of a grid that is at rest in a shape.
Residuals residuals_of(int nodes, const std::string& shape, const std::string& differences,
                       const std::string& more = "") {
  Simulation s = test::simulation_from_text(fmt::format(
      R"({{"surface": {{"plugin": "grid", "nodes": [{}, {}], "differences": "{}", "rest": {}{}}},
        "energies": [{{"plugin": "stretching", "eta": 1}}],
        "integrator": {{"plugin": "symplectic_euler", "step": 1e-6}}, "duration": 1e-6}})",
      nodes, nodes, differences, shape, more));
  Setup setup([](const PluginUse&, const Setup&) { return std::shared_ptr<Plugin>(); });
  const auto probe = std::dynamic_pointer_cast<Probe>(
      test::built_in()->create({PluginKind::probe, "compatibility", nullptr, ""}, setup));
  probe->begin({"", "", s.system(), {}, {}});
  std::array<double, 2> figures{};
  probe->measure(s.frame(), figures);
  return {figures[0], figures[1]};
}

std::string formula(const std::string& x, const std::string& y, const std::string& z) {
  return fmt::format(R"({{"plugin": "formula", "x": "{}", "y": "{}", "z": "{}"}})", x, y, z);
}

// Without rows from elsewhere: samples beside the border have no derivatives, and are left out.
const std::string kPaper = R"(, "border": "paper")";
const std::string kSphere = R"({"plugin": "sphere_patch", "radius": 0.8})";
/// A cylinder of radius 1 whose parameter lines are neither straight nor at right angles.
const std::string kCylinder =
    formula("sin(a1 + 0.3*a1*a2)", "a2 + 0.2*a1^2 + 0.1*a2^3", "cos(a1 + 0.3*a1*a2)");

TEST(Compatibility, OfACylinderWithItsLengthsIsExact) {
  // G and B are the same at all samples.
  const Residuals r = residuals_of(17, formula("sin(a1)", "a2", "cos(a1)"), "central", kPaper);
  EXPECT_LT(r.gauss, 1e-10);
  EXPECT_LT(r.codazzi, 1e-10);
}

/// Central differences, and forward ones followed by backward ones, which meet in the middle but
/// for the mixed derivatives.
TEST(Compatibility, HasTheOrderOfTheDifferences) {
  struct Case {
    std::string differences;
    double order;
  };
  for (const auto& [differences, order] : {Case{"forward", 1}, Case{"central", 2}})
    for (const std::string& shape : {kSphere, kCylinder}) {
      const Residuals coarse = residuals_of(33, shape, differences, kPaper),
                      fine = residuals_of(65, shape, differences, kPaper);
      // What comes next is relatively of the order of a mesh width, 1/64, and the area that is left
      // out of that of a few.
      EXPECT_NEAR(std::log2(coarse.gauss / fine.gauss), order, 0.15) << differences << shape;
      EXPECT_NEAR(std::log2(coarse.codazzi / fine.codazzi), order, 0.15) << differences << shape;
    }
}

/// At a border D_ii is that of the next line, which is wrong by a mesh width, in a strip as wide:
/// root mean squares are of order 3/2.
TEST(Compatibility, LosesHalfAnOrderToRowsOfOtherLines) {
  const Residuals coarse = residuals_of(33, kCylinder, "symmetric"),
                  fine = residuals_of(65, kCylinder, "symmetric");
  EXPECT_NEAR(std::log2(coarse.gauss / fine.gauss), 1.5, 0.15);
  EXPECT_NEAR(std::log2(coarse.codazzi / fine.codazzi), 1.5, 0.15);
}

TEST(Compatibility, HasSecondOrderOnAClosedSurface) {
  const std::string torus = R"({"plugin": "torus", "radius": 1, "tube": 0.4})";
  const auto residuals = [&](int nodes) {
    return residuals_of(nodes, torus, "central", R"(, "periodic": [true, true])");
  };
  const Residuals coarse = residuals(32), fine = residuals(64);
  EXPECT_NEAR(std::log2(coarse.gauss / fine.gauss), 2, 0.05);
  EXPECT_NEAR(std::log2(coarse.codazzi / fine.codazzi), 2, 0.05);
}

/// z = s cos(p_1 a1 + p_2 a2) with s → 0. With θ = p h, central differences of such a wave are
/// those of the smooth one with p replaced by S = sin θ / h, second ones with p² replaced by A = (2
/// sin(θ/2) / h)². To leading order in s,
///   B_ij = z_ij,  Γ^k_ij = z_ij z_k,
///   Codazzi:  (A_i − S_i²) S_j s sin φ,  φ = p·a, for (i, j) = (1, 2) and (2, 1),
///   Gauss:    ∂_2 (z_11 z_2) − ∂_1 (z_12 z_2) − (z_11 z_22 − z_12²).
TEST(Compatibility, OfAnUnresolvedWaveIsThatOfItsDifferences) {
  constexpr int kNodes = 21;
  constexpr double kHeight = 1e-5, h = 1.0 / (kNodes - 1), p_1 = 18, p_2 = 25;
  const Residuals r = residuals_of(
      kNodes, formula("a1", "a2", fmt::format("{}*cos({}*a1 + {}*a2)", kHeight, p_1, p_2)),
      "central", kPaper);

  const auto S = [](double p) { return std::sin(p * h) / h; };
  const auto A = [](double p) { return std::pow(2 * std::sin(p * h / 2) / h, 2); };
  const double S_1 = S(p_1), S_2 = S(p_2), A_1 = A(p_1), A_2 = A(p_2);
  double gauss = 0, codazzi = 0;
  int samples = 0;
  for (int i = 2; i < kNodes - 2; ++i)  // those whose neighbours have all derivatives
    for (int j = 2; j < kNodes - 2; ++j, ++samples) {
      const double phase = h * (p_1 * i + p_2 * j);
      const double curl = A_1 * S_2 * S(2 * p_2) - S_1 * S_2 * S_2 * S(2 * p_1);
      const double determinant = A_1 * A_2 - S_1 * S_1 * S_2 * S_2;
      gauss += std::pow(
          0.5 * curl * std::cos(2 * phase) - determinant * std::pow(std::cos(phase), 2), 2);
      codazzi += std::pow(std::sin(phase), 2) *
                 (std::pow((A_1 - S_1 * S_1) * S_2, 2) + std::pow((A_2 - S_2 * S_2) * S_1, 2));
    }
  // Squares of slopes, (s p)² ≈ 1e-7, come next; x and y, which are rounded to 1e-16, leave that
  // much of Γ in doubt, too.
  EXPECT_NEAR(r.codazzi / (kHeight * std::sqrt(codazzi / samples)), 1, 1e-6);
  EXPECT_NEAR(r.gauss / (kHeight * kHeight * std::sqrt(gauss / samples)), 1, 1e-6);
}

}  // namespace
}  // namespace deform
