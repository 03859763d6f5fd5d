#include "simulation/run_parts.h"

#include <cmath>
#include <utility>
#include <variant>

#include <fmt/format.h>

#include "deform/simulation/run.h"

#include "simulation/constraint_remarks.h"
#include "simulation/part_maker.h"
#include "simulation/shadow_probe.h"
#include "solve/asked.h"

namespace deform {

RunParts make_run_parts(const Scene& scene, const std::shared_ptr<const PluginRegistry>& registry) {
  std::shared_ptr<const Surface> own;  // where there is no simulation to take it from
  RunParts parts;
  PartMaker maker(scene, registry);
  const Surface* surface = nullptr;
  try {
    parts.simulation = std::make_unique<Simulation>(scene, registry);
    surface = &parts.simulation->system().surface();
  } catch (const InputError& e) {
    // Look at probes and outputs all the same, if there is a surface for them to look at.
    PartMaker again(scene, registry);
    if (auto made = again.make<Surface>(scene.surface(), again.setup())) own = made->object;
    surface = own.get();
    maker.add(e.problems());
  }
  if (surface != nullptr) {
    const NodeValues areas = areas_of_mass(*surface, scene.material);
    const Setup setup = maker.setup(*surface, surface->rest(), areas);
    parts.probes.emplace(scene.plugins[PluginKind::probe], maker, setup);
    add_shadows(scene, *registry, maker, setup, *parts.probes);
    parts.outputs.emplace(scene.plugins[PluginKind::output], maker, setup);
  }
  maker.throw_problems();
  return parts;
}

RunContext make_run_context(const RunParts& parts, const std::filesystem::path& folder) {
  Simulation& simulation = *parts.simulation;
  return {folder,
          simulation.scene().title,
          simulation.system(),
          [&simulation] { return simulation.mirrored(); },
          {}};
}

void begin_probes(RunParts& parts, const RunContext& context) {
  try {
    parts.probes->begin(context);
  } catch (const InputError& e) {
    std::vector<Problem> placed;
    for (const Problem& problem : e.problems()) {
      placed.push_back(parts.simulation->scene().located(problem));
    }
    throw InputError(std::move(placed));
  }
}

namespace {

/// Before all others, or by a recorder that has rules of its own.
bool made_otherwise(PluginKind kind) {
  return kind == PluginKind::surface || kind == PluginKind::probe || kind == PluginKind::output;
}

}  // namespace

std::vector<Problem> problems_of_sound_parts(const Scene& scene, const PluginRegistry& registry) {
  if (scene.plugins[PluginKind::surface].empty()) return {};
  PartMaker maker(scene, {std::shared_ptr<const PluginRegistry>(), &registry});
  if (const auto surface = maker.make<Surface>(scene.surface(), maker.setup())) {
    const NodeValues areas = areas_of_mass(*surface->object, scene.material);
    const Setup setup = maker.setup(*surface->object, surface->object->rest(), areas);
    for (const PluginKind kind : kPluginKinds)
      if (!made_otherwise(kind)) maker.try_all(kind, setup);
    ProbeRecorder probes(scene.plugins[PluginKind::probe], maker, setup);
    add_shadows(scene, registry, maker, setup, probes);
    const OutputRecorder outputs(scene.plugins[PluginKind::output], maker, setup);
  }
  return maker.problems();
}

std::vector<Problem> remarks_on(const Scene& scene) {
  std::vector<Problem> remarks;
  // Of a step: far more than rounding makes of the quotient, far less than anybody means.
  constexpr double kRounding = 1e-6;
  const auto steps = static_cast<double>(scene.steps());
  if (std::abs(scene.duration / scene.step - steps) > kRounding)
    remarks.push_back(scene.located(
        {"/duration",
         fmt::format("{} s is no whole number of steps of {} s: {} are run, to {:.6g} s",
                     scene.duration, scene.step, steps, steps * scene.step)}));
  for (const std::string& pointer : scene.dropped)
    remarks.push_back(scene.located(
        {pointer,
         fmt::format("at {}: dropped, as the plugin put in has no such parameter", pointer)}));
  for (const Problem& problem : scene.elsewhere)
    remarks.push_back({problem.pointer, problem.message + " (not needed for this run)"});
  return remarks;
}

std::vector<Problem> remarks_on(const RunParts& parts) {
  const Scene& scene = parts.simulation->scene();
  std::vector<Problem> remarks = remarks_on(scene);
  for (Problem& remark : constraint_remarks(*parts.simulation))
    remarks.push_back(scene.located(std::move(remark)));
  if (asked(parts.simulation->integrator(),
            [](const Integrator& i) { return i.lags_coefficients(); }))
    return remarks;
  const auto remark = [&](const std::string& pointer) {
    remarks.push_back(scene.located(
        {pointer,
         fmt::format("at {}: {} takes coefficients and jets from one state, where estimators like "
                     "gauss are exact: these angles, of coefficients a step old, are of no force "
                     "in this run; those of semi_implicit are",
                     pointer, scene.integrator().name)}));
  };
  for (const PluginUse& probe : scene.plugins[PluginKind::probe])
    if (probe.name == "normal_error") remark(probe.pointer);
  if (!scene.shadows.empty()) remark("/shadow");
  return remarks;
}

std::vector<Problem> check(const Scene& scene, std::shared_ptr<const PluginRegistry> registry) {
  RunParts parts = make_run_parts(scene, registry);
  begin_probes(parts, make_run_context(parts, {}));
  return remarks_on(parts);
}

}  // namespace deform
