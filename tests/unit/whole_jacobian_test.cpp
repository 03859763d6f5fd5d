/// Newton's method where no symmetric tangent knows all of the forces: directions are those of the
/// whole Jacobian, though it is never made.
#include <cmath>
#include <string>

#include <fmt/format.h>

#include "model/support/simulate.h"
#include "solve/system_parts.h"

namespace deform {
namespace {

using test::simulation_from_text;

Replacement integrator(const std::string& name, double step) {
  return {"/integrator",
          fmt::format(R"({{"plugin": "{}", "step": {}, "tolerance": 1e-9}})", name, step)};
}

/// Whether a Jacobian was made by differences and factorised.
bool made_a_jacobian(const System& system) {
  const auto& choices = SystemParts::of(system).meter.choices;
  return !choices[static_cast<std::size_t>(WorkMeter::Matrix::jacobian)].empty();
}

/// How much the last iterations that are not rounding yet take of the residual, at most.
double last_contraction(const StepReport& report) {
  double worst = 0;
  const std::vector<double>& r = report.residuals;
  for (std::size_t i = 1; i < r.size(); ++i)
    if (r[i - 1] < 1e-3 && r[i - 1] > 1e-7) worst = std::max(worst, r[i] / r[i - 1]);
  return worst;
}

/// In a storm the wind's derivatives by the place are as large as inertia: with the symmetric
/// tangent alone the residual shrinks by a half an iteration or less.
TEST(WholeJacobian, SolvesWithTheWindQuickly) {
  for (const char* method : {"backward_euler", "bdf2", "implicit_midpoint"}) {
    Simulation s = simulation_from_text(
        R"({"surface": {"plugin": "grid", "nodes": [11, 8], "size": [0.9, 0.6]},
            "material": {"density": 0.1},
            "energies": [{"plugin": "koiter", "young": 1e7, "poisson": 0.3, "thickness": 1e-4}],
            "forces": ["gravity", {"plugin": "wind", "velocity": [6, 0, 3]}],
            "constraints": [{"plugin": "pin", "where": {"boundary": "left"}}],
            "integrator": {"plugin": "bdf2", "step": 0.01}, "duration": 0.2})",
        {integrator(method, 0.01)});
    long with_jacobian = 0;
    while (s.steps() < s.scene().steps()) {
      s.step();
      const StepReport& report = s.system().step_report();
      EXPECT_EQ(report.rejected, 0) << method << ' ' << s.steps();
      EXPECT_LE(report.residual, 1e-9) << method << ' ' << s.steps();
      EXPECT_LE(last_contraction(report), 0.2) << method << ' ' << s.steps();
      with_jacobian += report.with_jacobian;
    }
    EXPECT_GT(with_jacobian, 0) << method;
    EXPECT_FALSE(made_a_jacobian(s.system())) << method;
  }
}

/// The paper's bending in all its forms: M (v⁺ − v)/h = f(r⁺) − Γ v⁺ by the forces themselves.
TEST(WholeJacobian, SolvesWithThePapersBending) {
  const std::string forms[] = {
      R"({"plugin": "bending", "xi": 1e-5})",
      R"({"plugin": "bending", "xi": 1e-5, "normal": {"plugin": "gauss", "delta": 0.5}})",
      R"({"plugin": "bending", "xi": 1e-5, "normal": "terzopoulos"})",
      R"({"plugin": "bending", "xi": 1e-5, "form": "expanded",
          "normal": {"plugin": "gauss", "delta": 0.5}})"};
  for (const std::string& bending : forms) {
    Simulation s = test::simulation_of("benchmarks/sheet_p.json", "base",
                                       {{"/surface/nodes", "[13, 13]"},
                                        {"/duration", "0.2"},
                                        {"/energies/1", bending},
                                        integrator("backward_euler", 0.02)});
    while (s.steps() < s.scene().steps()) {
      const State before = s.state();
      s.step();
      const System& system = s.system();
      NodeVectors residual = system.evaluator().force(s.state());
      const double scale = residual.norm();
      for (int c = 0; c < 3; ++c)
        residual.col(c) -= system.mass().cwiseProduct(s.state().v.col(c) - before.v.col(c)) / 0.02 +
                           system.damping().cwiseProduct(s.state().v.col(c));
      system.constraints().reduce_force(residual);
      EXPECT_LE(residual.norm(), 1e-8 * scale) << bending;
      EXPECT_EQ(system.step_report().rejected, 0) << bending;
      EXPECT_LE(system.step_report().iterations, 10) << bending;
    }
    EXPECT_FALSE(made_a_jacobian(s.system())) << bending;
  }
}

}  // namespace
}  // namespace deform
