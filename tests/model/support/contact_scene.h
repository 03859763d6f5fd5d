/// A sheet of a few nodes and what it touches, under every integrator.
#pragma once

#include <string>
#include <vector>

#include <fmt/format.h>

#include "model/support/simulate.h"

namespace deform::test {

struct Method {
  std::string integrator;
  std::string
      energies;  // under implicit methods, one without a potential leaves contact to the end
};

inline std::vector<Method> methods() {
  const std::string without_potential = R"([{"plugin": "bending", "xi": 1e-12}])";
  return {{"semi_implicit", "[]"},
          {"symplectic_euler", "[]"},
          {"runge_kutta", "[]"},
          {"backward_euler", "[]"},
          {"bdf2", "[]"},
          {"implicit_midpoint", "[]"},
          {"backward_euler", without_potential},
          {"bdf2", without_potential},
          {"implicit_midpoint", without_potential}};
}

inline std::string name_of(const Method& m) { return m.integrator + " with " + m.energies; }

inline bool is_implicit(const Method& m) {
  return m.integrator != "runge_kutta" && m.integrator != "symplectic_euler" &&
         m.integrator != "semi_implicit";
}

/// A sheet on the plane z = 0, to be put elsewhere by pointers.
inline Simulation sheet(const Method& m, double step, double duration,
                        std::vector<Replacement> replacements) {
  replacements.insert(
      replacements.begin(),
      {{"/energies", m.energies},
       {"/integrator", fmt::format(R"({{"plugin": "{}", "step": {}{}}})", m.integrator, step,
                                   is_implicit(m) ? R"(, "tolerance": 1e-10)" : "")},
       {"/duration", std::to_string(duration)}});
  return simulation_from_text(
      R"({"surface": {"plugin": "grid", "nodes": [3, 3], "size": [1, 1]},
          "material": {"density": 1}, "energies": [], "forces": [], "constraints": [],
          "colliders": [], "velocity": [0, 0, 0], "limits": {"distance": 100}, "integrator": {"plugin": "symplectic_euler", "step": 0.01}, "duration": 1})",
      replacements);
}

/// The plane at a height, with friction, and further keys of a collider (", …").
inline Replacement plane(double z, double friction, const std::string& more = "") {
  return {"/colliders/-",
          fmt::format(R"({{"plugin": "plane", "point": [0, 0, {}], "friction": {}{}}})", z,
                      friction, more)};
}
inline Replacement velocity(double x, double z) {
  return {"/velocity", fmt::format("[{}, 0, {}]", x, z)};
}

/// Such a sheet after its last step.
class Ended {
 public:
  Ended(const Method& m, double step, double duration, const std::vector<Replacement>& replacements)
      : simulation_(sheet(m, step, duration, replacements)) {
    EXPECT_FALSE(test::run_to_end(simulation_)) << name_of(m);
  }
  [[nodiscard]] const State& state() const { return simulation_.state(); }
  System& system() { return simulation_.system(); }

 private:
  Simulation simulation_;
};

template <class Run>
double largest_speed(const Run& s) {
  return s.state().v.rowwise().norm().maxCoeff();
}

}  // namespace deform::test
