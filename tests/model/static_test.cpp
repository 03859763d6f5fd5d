/// Equilibria: closed forms, Newton's order, surfaces that nothing holds, stability.
#include <cmath>
#include <string>

#include <fmt/format.h>

#include "deform/check/mechanics.h"
#include "deform/solve/linear_solver.h"
#include "deform/solve/newton_matrix.h"

#include "model/support/simulate.h"

namespace deform {
namespace {

using test::simulation_from_text;
using test::simulation_of;

std::string sheet(const std::string& forces, const std::string& constraints,
                  const std::string& integrator = R"({"plugin": "static", "step": 1})") {
  return R"({"surface": {"plugin": "grid", "nodes": [9, 7], "size": [1.0, 0.6],
              "differences": "symmetric", "border": "one_sided", "weights": "area"},
             "material": {"density": 1.0},
             "energies": [{"plugin": "koiter", "young": 1000, "poisson": 0.3, "thickness": 0.01}],
             "forces": [)" +
         forces + R"(], "constraints": [)" + constraints + R"(], "integrator": )" + integrator +
         R"(, "duration": 1})";
}

const std::string kPulled =
    R"({"plugin": "edge_load", "where": {"boundary": "right"}, "force": [0.5, 0, 0]},
       {"plugin": "edge_load", "where": {"boundary": "left"}, "force": [-0.5, 0, 0]})";

/// A uniaxial dead load p per length of a St. Venant–Kirchhoff membrane: λ (λ² − 1)/2 = p/(E h),
/// and across it G_22 = 1 − ν (G_11 − 1).
TEST(Static, StretchesAFreeSheetAsTheClosedFormSays) {
  Simulation s = simulation_from_text(sheet(kPulled, ""));
  s.step();
  double lambda = 1;
  for (int i = 0; i < 50; ++i)
    lambda -= (lambda * (lambda * lambda - 1) / 2 - 0.5 / 10) / ((3 * lambda * lambda - 1) / 2);
  const NodeVectors& r = s.state().r;
  const double length = r.col(0).maxCoeff() - r.col(0).minCoeff();
  const double width = r.col(1).maxCoeff() - r.col(1).minCoeff();
  EXPECT_NEAR(length, lambda, 1e-9);
  EXPECT_NEAR(width / 0.6, std::sqrt(1 - 0.3 * (lambda * lambda - 1)), 1e-9);
}

TEST(Static, RefusesLoadsThatNothingBalances) {
  Simulation s =
      simulation_from_text(sheet(R"({"plugin": "gravity", "acceleration": [0, 0, -1e-3]})", ""));
  try {
    s.step();
    FAIL() << "it found an equilibrium";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::diverged);
    EXPECT_NE(std::string(error.what()).find("nothing holds the surface"), std::string::npos)
        << error.what();
  }
}

/// A thin sheet that falls crumples about what is held against rigid motions; holding others then
/// takes no load off.
TEST(Static, RefusesWhatOnlyCrumples) {
  for (const int n : {3, 4, 5, 9}) {
    Simulation s = simulation_from_text(fmt::format(
        R"({{"surface": {{"plugin": "grid", "nodes": [{0}, {0}], "size": [0.5, 0.5]}},
            "material": {{"density": 0.2}}, "forces": ["gravity"],
            "energies": [{{"plugin": "koiter", "young": 1e6, "poisson": 0.3, "thickness": 1e-3}}],
            "integrator": {{"plugin": "static", "step": 1}}, "duration": 1}})",
        n));
    try {
      s.step();
      ADD_FAILURE() << n << ": it found an equilibrium";
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ExitCode::diverged) << n;
    }
  }
}

/// The residuals of the last iterations fall quadratically, until rounding.
TEST(Static, NewtonConvergesQuadratically) {
  Simulation s = simulation_of("benchmarks/elastica_tip_load.json", "base",
                               {{.pointer = "/energies/0/thickness", .value = "0.05"},
                                {.pointer = "/energies/0/young", .value = "96000"},
                                {.pointer = "/integrator/tolerance", .value = "1e-12"}});
  s.step();
  const std::vector<double> residuals = s.system().step_report().residuals;
  std::string table;
  for (const double r : residuals) table += std::to_string(std::log10(r)) + " ";
  RecordProperty("log10_residuals", table);
  int close = 0;
  for (std::size_t i = 1; i < residuals.size(); ++i) {
    // Close enough to the end, and far enough from rounding, for a step to be told from a linear
    // one: from 1e-3 that would be no better than 1e-4.
    if (residuals[i - 1] > 1e-3 || residuals[i - 1] < 1e-6) continue;
    ++close;
    EXPECT_LT(residuals[i], 30 * residuals[i - 1] * residuals[i - 1]) << table;
  }
  EXPECT_GE(close, 1) << table;
  EXPECT_LT(residuals.size(), 15U) << table;
  EXPECT_LT(residuals.back(), 1e-9) << table;
}

/// A sheet that is pressed in its plane beyond Euler's load stays flat by symmetry, and is said to
/// be unstable; pushed aside a little, it leaves.
TEST(Static, KnowsThatACompressedSheetIsUnstable) {
  const std::string held = R"({"plugin": "clamp", "where": {"boundary": "left"}})";
  const auto pressed = [&](double load, const std::string& more) {
    Simulation s = simulation_from_text(
        sheet(R"({"plugin": "edge_load", "where": {"boundary": "right"}, "force": [)" +
                  std::to_string(-load) + ", 0, 0]}" + more,
              held));
    s.step();
    NewtonMatrix tangent(s.system());
    tangent.evaluate(s.state());
    return std::pair{tangent.stability().lowest, s.state().r.col(2).cwiseAbs().maxCoeff()};
  };
  const double euler =
      M_PI * M_PI / 4 * 1000 * 1e-6 / 12;  // EI a width, nu = 0: a bound from below
  EXPECT_GT(pressed(0.8 * euler, "").first, 0);
  const auto [lowest, aside] = pressed(1.3 * euler, "");
  EXPECT_LT(lowest, 0);
  EXPECT_LT(aside, 1e-9);
  const std::string nudge =
      R"(, {"plugin": "edge_load", "where": {"boundary": "right"}, "force": [0, 0, 1e-7]})";
  EXPECT_LT(pressed(0.8 * euler, nudge).second, 0.01);
  const auto [after, far] = pressed(1.3 * euler, nudge);
  EXPECT_GT(after, 0);
  EXPECT_GT(far, 0.2);
}

/// Each named rest shape, turned and moved as a whole: no force of any part of Koiter's energy.
TEST(Static, RigidMotionsOfNamedShapesLeaveNoForce) {
  for (const char* rest :
       {R"({"plugin": "flat"})", R"({"plugin": "arc", "radius": 0.5})",
        R"({"plugin": "sphere_patch", "radius": 1.5})", R"({"plugin": "hemisphere", "radius": 1})",
        R"({"plugin": "torus", "radius": 1, "tube": 0.3})",
        R"({"plugin": "helicoid", "height": 0.5})",
        R"({"plugin": "wave", "amplitude": 0.1, "wavelength": 0.7})"}) {
    SCOPED_TRACE(rest);
    Simulation s = simulation_from_text(
        std::string(R"({"surface": {"plugin": "grid", "nodes": [9, 8], "size": [1.0, 0.8],
            "differences": "symmetric", "border": "one_sided", "weights": "area", "rest": )") +
        rest + R"(}, "material": {"density": 1.0}, "energies": [{"plugin": "koiter", "young": 50,
            "poisson": 0.3, "thickness": 0.05}], "integrator": {"plugin": "static", "step": 1},
            "duration": 1})");
    System& system = s.system();
    State moved = deform::disturbed(system.rest(), 0.03);
    std::vector<double> scale;
    for (std::size_t term = 0; term < 2; ++term)
      scale.push_back(system.terms().internal_force(term, moved).norm());
    const Eigen::Matrix3d turn =
        Eigen::AngleAxisd(2.1, Vec3(1, -2, 0.5).normalized()).toRotationMatrix();
    moved.r = (system.rest() * turn.transpose()).eval().rowwise() + Eigen::RowVector3d(1, -2, 3);
    for (std::size_t term = 0; term < 2; ++term)
      EXPECT_LT(system.terms().internal_force(term, moved).norm(), 1e-9 * scale[term]);
  }
}

/// Ten rest shapes by formula: no force after a rigid motion, forces and tangents are derivatives.
TEST(Static, RandomRestShapesKeepTheRules) {
  std::srand(7);
  const auto number = [] {
    return std::to_string(0.3 * (2.0 * std::rand() / RAND_MAX - 1));  // NOLINT: fixed seed
  };
  for (int k = 0; k < 10; ++k) {
    const std::string rest = "{\"plugin\": \"formula\", \"x\": \"a1+" + number() + "*a2^2+" +
                             number() + "*sin(2*a2)\", \"y\": \"a2+" + number() + "*a1*a2+" +
                             number() + "*cos(a1)\", \"z\": \"" + number() + "*sin(3*a1+a2)+" +
                             number() + "*a2^2\"}";
    SCOPED_TRACE(rest);
    Simulation s = simulation_from_text(
        R"({"surface": {"plugin": "grid", "nodes": [7, 6], "size": [1.0, 0.8], "differences":
            "symmetric", "border": "one_sided", "weights": "area", "rest": )" +
        rest + R"(}, "material": {"density": 1.0}, "energies": [{"plugin": "koiter", "young": 50,
            "poisson": 0.3, "thickness": 0.05}], "integrator": {"plugin": "static", "step": 1},
            "duration": 1})");
    System& system = s.system();
    const State disturbed = deform::disturbed(system.rest(), 0.03);
    EXPECT_LT(tangent_error(system, disturbed), 1e-6);
    for (std::size_t term = 0; term < system.energies().size(); ++term) {
      EXPECT_LT(gradient_error(system, term, disturbed), 1e-6);
      State moved = disturbed;
      const Eigen::Matrix3d turn =
          Eigen::AngleAxisd(0.7, Vec3(1, 2, -0.5).normalized()).toRotationMatrix();
      moved.r = (system.rest() * turn.transpose()).eval().rowwise() + Eigen::RowVector3d(1, 2, 3);
      EXPECT_LT(system.terms().internal_force(term, moved).norm(),
                1e-9 * system.terms().internal_force(term, disturbed).norm());
    }
  }
}

}  // namespace
}  // namespace deform
