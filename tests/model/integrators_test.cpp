/// Integrators against each other and against motions with known answers; prescribed motion;
/// periodic sides.
#include <cmath>
#include <numbers>

#include "model/support/simulate.h"

namespace deform {
namespace {

using test::run_to_end;
using test::simulation_from_text;

std::string pressed_sheet(const std::string& integrator, double step,
                          const std::string& more = "") {
  return R"({"surface": {"plugin": "grid", "nodes": [11, 11], "differences": "forward",
                      "border": "one_sided"},
    "material": {"density": 0.1, "damping": 0.5},
    "energies": [{"plugin": "stretching", "eta": 0.01}, {"plugin": "bending_variational", "xi": 1e-5}],
    "forces": [{"plugin": "point_load", "force": [0, 0, -0.01], "where": {"centre": [0.5, 0.5], "radius": 0.1}},
               {"plugin": "spring", "anchor": [0.5, 0.5, 0.3], "stiffness": 0.02, "where": {"node": 60}},
               {"plugin": "viscous_fluid", "viscosity": 0.1, "velocity": [0, 0.2, 0.1],
                "time": {"table": [[0, 0], [0.5, 1]]}}],
    "constraints": [{"plugin": "pin", "where": {"boundary": "left"}},
                    {"plugin": "pin", "where": {"boundary": "bottom"}, "components": ["y"]})" +
         more + R"(],
    "integrator": {"plugin": ")" +
         integrator + R"(", "step": )" + std::to_string(step) + R"(}, "duration": 1.0})";
}

NodeVectors final_positions(const std::string& text) {
  Simulation s = simulation_from_text(text);
  EXPECT_FALSE(run_to_end(s));
  EXPECT_NEAR(s.state().time, 1.0, 1e-12);
  return s.state().r;
}

/// Two different integrators converge to the same motion, each with order one.
TEST(Integrators, AgreeWithEachOtherUnderRefinement) {
  const std::string move = R"(, {"plugin": "move", "where": {"boundary": "right"}, "times": [0, 1],
      "displacements": [[0, 0, 0], [0.05, 0, 0.1]]})";
  const auto difference = [&](double step) {
    return (final_positions(pressed_sheet("semi_implicit", step, move)) -
            final_positions(pressed_sheet("symplectic_euler", step, move)))
        .norm();
  };
  const double coarse = difference(2e-3), fine = difference(1e-3);
  EXPECT_LT(fine, 1e-3);
  EXPECT_NEAR(coarse / fine, 2.0, 0.2);
}

TEST(Constraints, PrescribedNodesAreWhereThePathSays) {
  const std::string move =
      R"(, {"plugin": "move", "where": {"boundary": "right"}, "times": [0, 0.5, 1],
      "displacements": [[0, 0, 0], [0.05, 0, 0.1], [0, 0, 0.1]]})";
  for (const char* integrator : {"semi_implicit", "symplectic_euler"}) {
    Simulation s = simulation_from_text(pressed_sheet(integrator, 1e-3, move));
    const NodeVectors initial = s.state().r;
    while (s.steps() < 250) s.step();
    for (const Index a : s.system().surface().boundary("right")) {
      EXPECT_EQ(s.state().r(a, 2), initial(a, 2) + 0.5 * 0.1) << integrator;
      EXPECT_NEAR(s.state().v(a, 2), 0.2, 1e-9) << integrator;
      EXPECT_NEAR(s.state().v(a, 0), 0.1, 1e-9) << integrator;
    }
    for (const Index a : s.system().surface().boundary("left"))
      EXPECT_EQ(s.state().r.row(a), initial.row(a)) << integrator;
    for (const Index a : s.system().surface().boundary("bottom"))
      EXPECT_EQ(s.state().r(a, 1), initial(a, 1)) << integrator;
  }
}

/// A free sheet falls: v = −g t exactly for both, r = −½ g t (t ± dt) with the sign of a
/// first-order method.
TEST(Integrators, FreeFall) {
  for (const auto& [integrator, sign] :
       {std::pair{"semi_implicit", 1.0}, {"symplectic_euler", 1.0}}) {
    Simulation s = simulation_from_text(
        std::string(
            R"({"surface": {"plugin": "grid", "nodes": [5, 5], "differences": "forward"},
                "material": {"density": 0.3},
          "energies": [{"plugin": "stretching"}], "forces": [{"plugin": "gravity"}],
          "integrator": {"plugin": ")") +
        integrator + R"(", "step": 0.01}, "duration": 0.5})");
    ASSERT_FALSE(run_to_end(s));
    EXPECT_NEAR(s.state().v.col(2).mean(), -9.81 * 0.5, 1e-10) << integrator;
    EXPECT_NEAR(s.state().r.col(2).mean(), -0.5 * 9.81 * 0.5 * (0.5 + sign * 0.01), 1e-10)
        << integrator;
  }
}

/// Terminal speed under damping: m g/γ.
TEST(Integrators, TerminalSpeed) {
  Simulation s = simulation_from_text(
      R"({"surface": {"plugin": "grid", "nodes": [5, 5], "differences": "forward"},
          "material": {"density": 0.1, "damping": 2.0},
        "energies": [{"plugin": "stretching"}], "forces": [{"plugin": "gravity"}], "limits": {"distance": 100},
        "integrator": {"plugin": "semi_implicit", "step": 0.01}, "duration": 3})");
  ASSERT_FALSE(run_to_end(s));
  EXPECT_NEAR(s.state().v.col(2).mean(), -0.1 * 9.81 / 2.0, 1e-10);
}

/// With cholmod an indefinite matrix goes to another solver: the motion is that of this solver from
/// the start.
TEST(Solvers, HandingOverDoesNotChangeTheMotion) {
  const auto run = [](const std::string& solver) {
    std::vector<Replacement> set{{"/duration", "0.12"}};
    if (!solver.empty()) set.push_back({"/solver", "\"" + solver + "\""});
    Simulation s = test::simulation_of("benchmarks/sheet_p.json", "terzopoulos_1e-5", set);
    EXPECT_FALSE(run_to_end(s));
    return s.state().r;
  };
  const NodeVectors chosen = run(""), umfpack = run("umfpack"), eigen = run("eigen_lu"),
                    iterative = run("bicgstab");
  EXPECT_LT((chosen - umfpack).norm(), 1e-9 * chosen.norm());
  EXPECT_LT((chosen - eigen).norm(), 1e-9 * chosen.norm());
  EXPECT_LT((chosen - iterative).norm(), 1e-5 * chosen.norm());  // each increment to 1e-6
}

/// A tube: rest shape of a full circle, joined along a1. Stress-free at rest, no seam anywhere.
TEST(Periodic, TubeHasNoSeam) {
  Simulation s = simulation_from_text(
      R"({"surface": {"plugin": "grid", "nodes": [24, 9], "size": [1, 0.5], "differences": "forward",
                      "periodic": [true, false],
          "rest": {"plugin": "arc", "radius": 0.15915494309189535}},
        "energies": [{"plugin": "stretching", "eta": 0.01}, {"plugin": "bending_variational", "xi": 1e-4}],
        "integrator": {"plugin": "semi_implicit", "step": 0.01}, "duration": 0.1})");
  System& system = s.system();
  EXPECT_EQ(system.surface().faces().size(), 24 * 8);
  // Blow it up radially and stretch it: by symmetry every node of a ring has the same radial force.
  State state = s.state();
  const Vec2 axis(0.5, state.r.col(2).mean());
  for (Index a = 0; a < state.r.rows(); ++a) {
    state.r(a, 0) = axis.x() + 1.1 * (state.r(a, 0) - axis.x());
    state.r(a, 2) = axis.y() + 1.1 * (state.r(a, 2) - axis.y());
  }
  for (std::size_t term = 0; term < 2; ++term) {
    const NodeVectors f = system.terms().internal_force(term, state);
    for (Index ring = 0; ring < 9; ++ring)
      for (Index i = 1; i < 24; ++i)
        EXPECT_NEAR(f.row(24 * ring + i).norm(), f.row(24 * ring).norm(), 1e-12 * f.norm());
  }
}

}  // namespace
}  // namespace deform
