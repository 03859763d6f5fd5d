// The commonest scene with contact: cloth falls on a ball and a floor.
#include <string>

#include <gtest/gtest.h>

#include "model/support/simulate.h"

namespace {
using namespace deform;

Simulation falling_sheet(const std::string& integrator, double friction, int nodes = 21) {
  const std::string mu = std::to_string(friction), n = std::to_string(nodes);
  return test::simulation_from_text(
      R"({"surface": {"plugin": "grid", "nodes": [)" + n + ", " + n + R"(], "size": [1, 1]},
          "material": {"density": 0.2},
          "energies": [{"plugin": "koiter", "young": 1e5, "poisson": 0.3, "thickness": 1e-3}],
          "forces": [{"plugin": "gravity"}], "constraints": [], "colliders": [
            {"plugin": "sphere", "centre": [0.5, 0.5, -0.35], "radius": 0.3, "friction": )" +
      mu + R"(}, {"plugin": "plane", "point": [0, 0, -0.66], "normal": [0, 0, 1], "friction": )" +
      mu + R"(}], "integrator": {"plugin": ")" + integrator +
      R"(", "step": 0.01}, "duration": 0.7})");
}

/// At the default settings: no step is halved (hardly one under the midpoint rule), a step takes
/// few iterations, no node is inside.
TEST(FallingSheet, TakesFewIterationsAndStaysOutside) {
  for (const char* integrator : {"backward_euler", "bdf2", "implicit_midpoint"})
    for (const double friction : {0.0, 0.3}) {
      Simulation s = falling_sheet(integrator, friction);
      long iterations = 0, rejected = 0;
      while (s.steps() < s.scene().steps()) {
        s.step();
        const StepReport& report = s.system().step_report();
        iterations += report.iterations;
        rejected += report.rejected;
        EXPECT_GE(s.system().contact().clearance(s.state().time, s.state().r).minCoeff(), -1e-12)
            << integrator << ' ' << friction << ' ' << s.steps();
      }
      // Nothing damps wrinkles under the midpoint rule.
      EXPECT_LE(rejected, integrator == std::string("implicit_midpoint") ? 2 : 0)
          << integrator << ' ' << friction;
      EXPECT_LE(iterations, 10 * s.steps()) << integrator << ' ' << friction;
      EXPECT_LT(s.state().r.col(2).maxCoeff(), -0.049) << "it lies on the ball";
      EXPECT_LT(s.state().r.col(2).minCoeff(), -0.45) << "and hangs down its sides";
    }
}

/// Thin cloth buckles, where the projected tangent is much stiffer than the surface: a step that
/// ends by the error it leaves has balanced most of the forces all the same.
TEST(FallingSheet, LeavesNoStepUnsolved) {
  Simulation s = falling_sheet("backward_euler", 0.3, 41);
  for (int step = 0; step < 40; ++step) {
    s.step();
    EXPECT_LT(s.system().step_report().residual, 0.5) << s.steps();
  }
}

}  // namespace
