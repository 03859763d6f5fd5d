#include "simulation/solver_check.h"

#include <algorithm>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "deform/solve/linear_solver.h"

#include "plugin/guard.h"
#include "simulation/part_maker.h"
#include "solve/asked.h"

namespace deform {
namespace {

/// A matrix as a user hears of it, and what a solver is asked.
struct Wanted {
  std::string text;
  MatrixTraits traits;
  bool blocks = false;  // a BlockSolver will do
};

/// Where all has a potential with a tangent the matrix is symmetric, else a Jacobian.
bool is_symmetric(const System& system, bool with_loads) {
  if (!with_loads) return have_potential(system);
  return system.evaluator().without_potential().empty() &&
         system.evaluator().without_tangent().empty();
}

bool solves_nothing(const Named<Integrator>& integrator) {
  return asked(integrator, [](const Integrator& i) { return i.solves(); }) ==
         Integrator::Solves::nothing;
}

Wanted wanted_by(const Named<Integrator>& integrator, const System& system) {
  const bool has_ties = !system.constraints().reduction().ties().empty();
  const bool is_static = deform::is_static(integrator);
  Wanted wanted;
  wanted.traits = {.size = 3 * system.rows(), .symmetric = true, .positive_definite = true};
  if (solves_nothing(integrator)) {
    wanted.text = "the matrix of masses of tied unknowns, as clamps and symmetries make them";
  } else if (!is_symmetric(system, is_static)) {
    wanted.traits.symmetric = wanted.traits.positive_definite = false;
    wanted.text = "an unsymmetric matrix, as there is where energies or loads have no potential";
  } else if (is_static) {
    wanted.text = "a matrix that has to be factorised, as equilibria need it";
  } else if (has_ties) {
    wanted.text = "a matrix of tied unknowns, as clamps and symmetries make them";
  } else {
    wanted.text = "a matrix of 3 × 3 blocks";
    wanted.blocks = true;
  }
  return wanted;
}

bool takes(const Named<LinearSolver>& solver, const Wanted& wanted, Index nodes) {
  return guarded(solver.origin, "judging a matrix", [&] {
    BlockSolver* const blocks = wanted.blocks ? solver.object->blocks() : nullptr;
    return (blocks != nullptr ? blocks->block_suitability(nodes)
                              : solver.object->suitability(wanted.traits)) > 0;
  });
}

/// Those of all solvers that take the matrix, best first.
std::vector<std::string> others_that_take(const Wanted& wanted, const Scene& scene,
                                          const PluginRegistry& registry, const System& system) {
  std::vector<std::pair<double, std::string>> found;
  for (const std::string& name : registry.names(PluginKind::solver)) {
    try {
      PartMaker maker(scene, {std::shared_ptr<const PluginRegistry>(), &registry});
      const auto solver =
          maker.make<LinearSolver>({PluginKind::solver, name, nullptr, "/solver"},
                                   maker.setup(system.surface(), system.rest(), system.areas()));
      if (solver && takes(*solver, wanted, system.rows()))
        found.emplace_back(
            -asked(*solver, [&](const LinearSolver& s) { return s.suitability(wanted.traits); }),
            name);
    } catch (const Error&) {  // one that does not load is none to recommend
      continue;
    }
  }
  std::ranges::sort(found);
  std::vector<std::string> names;
  for (const auto& [suitability, name] : found) names.push_back('"' + name + '"');
  return names;
}

}  // namespace

void require_solver(const Scene& scene, const PluginRegistry& registry, const System& system,
                    const Named<Integrator>& integrator, const MakeSolvers& make_solvers) {
  if (solves_nothing(integrator) && system.constraints().reduction().ties().empty()) return;
  const Wanted wanted = wanted_by(integrator, system);
  const std::vector<Named<LinearSolver>> solvers = make_solvers();
  const bool any = std::ranges::any_of(
      solvers, [&](const auto& solver) { return takes(solver, wanted, system.rows()); });
  if (any) return;
  const std::vector<std::string> others = others_that_take(wanted, scene, registry, system);
  throw InputError(
      {{"/solver",
        fmt::format(
            "at /solver: found \"{}\", which does not take {} (integrator \"{}\"), expected "
            "{}",
            solvers.empty() ? "none" : solvers.front().name, wanted.text, scene.integrator().name,
            others.empty() ? std::string("one that does")
                           : fmt::format("{}", fmt::join(others, " or ")))}});
}

}  // namespace deform
