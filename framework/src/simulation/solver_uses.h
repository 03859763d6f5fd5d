/// Which linear solvers a simulation gets.
#pragma once

#include <string>
#include <vector>

#include "deform/error.h"
#include "deform/plugin/registry.h"
#include "deform/simulation/scene.h"

namespace deform {

struct SolverUses {
  std::vector<PluginUse> uses;
  std::vector<std::string> left_out;  ///< one message a solver that does not load
  std::vector<Problem> problems;      ///< why `uses` is empty, when it is
};

/// The scene's solver; where it names none, every solver plugin that loads, with its defaults (the
/// System takes the one that suits its matrix best).
[[nodiscard]] SolverUses solver_uses(const Scene& scene, const PluginRegistry& registry);

}  // namespace deform
