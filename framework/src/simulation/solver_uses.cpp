#include "simulation/solver_uses.h"

namespace deform {

SolverUses solver_uses(const Scene& scene, const PluginRegistry& registry) {
  SolverUses found;
  found.uses = scene.plugins[PluginKind::solver];
  if (!found.uses.empty()) return found;
  for (const std::string& name : registry.names(PluginKind::solver)) {
    try {
      (void)registry.load(PluginKind::solver, name);
      found.uses.push_back({PluginKind::solver, name, nullptr, "/solver"});
    } catch (const InputError& e) {
      // A scene that is silent asks for no solver in particular: one that is broken is not its
      // fault.
      found.left_out.push_back("solver '" + name + "' is left out: " + e.what());
    }
  }
  if (found.uses.empty()) {
    for (const std::string& message : found.left_out)
      found.problems.push_back({"/solver", message});
    if (found.left_out.empty()) found.problems.push_back({"/solver", "no solver plugin was found"});
  }
  return found;
}

}  // namespace deform
