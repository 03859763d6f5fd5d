/// Results do not depend on where the origin is.
#include <cmath>
#include <string>

#include "model/support/simulate.h"

namespace deform {
namespace {

using test::simulation_from_text;

/// A held sheet sags; `x`: where it lies, in sizes of it.
std::string scene(const std::string& x, const std::string& integrator) {
  return R"({"surface": {"plugin": "grid", "nodes": [9, 9], "size": [1, 1],
                         "rest": {"plugin": "formula", "x": "a1+)" +
         x + R"("}}, "material": {"density": 0.2},
             "energies": [{"plugin": "koiter", "young": 1e6, "poisson": 0.3, "thickness": 1e-3}],
             "forces": ["gravity"],
             "constraints": [{"plugin": "pin", "where": {"boundary": "all"}}],
             "integrator": )" +
         integrator + R"(, "duration": 0.1})";
}

double lowest(const std::string& x, const std::string& integrator) {
  Simulation s = simulation_from_text(scene(x, integrator));
  const auto diverged = test::run_to_end(s);
  EXPECT_FALSE(diverged) << (diverged ? diverged->what() : "");
  return s.state().r.col(2).minCoeff();
}

/// 1024 sizes away positions are rounded to 1e-13 of the size, strains between nodes to 1e-12.
TEST(FarFromOrigin, TheSagIsTheSame) {
  for (const char* integrator :
       {R"({"plugin": "static", "step": 0.1})", R"({"plugin": "backward_euler", "step": 0.02})",
        R"({"plugin": "bdf2", "step": 0.02})", R"({"plugin": "implicit_midpoint", "step": 0.02})",
        R"({"plugin": "symplectic_euler", "step": 5e-4})",
        R"({"plugin": "runge_kutta", "step": 5e-4})"}) {
    const double near = lowest("0", integrator), far = lowest("1024", integrator);
    EXPECT_LT(near, -1e-3) << integrator;
    EXPECT_LT(std::abs(far - near), 1e-6 * std::abs(near)) << integrator;
  }
}

}  // namespace
}  // namespace deform
