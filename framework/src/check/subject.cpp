#include "check/subject.h"

#include <array>
#include <filesystem>

namespace deform {

std::vector<Terrain> terrains(int n1, int n2) {
  struct Scheme {
    const char *name, *differences, *border, *weights;
  };
  const std::array<Scheme, 4> schemes{{{"forward", "forward", "one_sided", "equal"},
                                       {"central", "central", "one_sided", "area"},
                                       {"paper", "forward", "paper", "equal"},
                                       {"symmetric", "symmetric", "one_sided", "area"}}};
  const std::array<std::pair<const char*, Json>, 3> rests{
      {{"flat", {{"plugin", "flat"}}},
       {"arc", {{"plugin", "arc"}, {"radius", 0.5}}},
       {"sphere", {{"plugin", "sphere_patch"}, {"radius", 1.5}}}}};
  std::vector<Terrain> all;
  for (const auto& [rest_name, rest] : rests)
    for (const Scheme& s : schemes) {
      const Json surface{{"plugin", "grid"},   {"nodes", {n1, n2}},
                         {"size", {1.0, 0.8}}, {"differences", s.differences},
                         {"border", s.border}, {"weights", s.weights},
                         {"rest", rest}};
      all.push_back(
          {std::string(rest_name) + ", " + s.name, surface, std::string(s.border) != "paper"});
    }
  return all;
}

Json Subject::use() const {
  Json use{{"plugin", plugin_.file().name}};
  use.update(parameters_);
  return use;
}

Json Subject::scene_json(const Terrain& terrain) const {
  Json use = this->use();
  Json scene{
      {"title", "check"},
      {"surface", terrain.surface},
      {"material", {{"density", 0.1}, {"damping", 0.1}}},
      {"energies", Json::array({{{"plugin", "stretching"}, {"eta", 0.01}}})},
      {"forces", Json::array({{{"plugin", "gravity"}, {"acceleration", {0, 0, -1}}}})},
      {"constraints", Json::array({{{"plugin", "pin"}, {"where", {{"boundary", "left"}}}}})},
      {"integrator", {{"plugin", "semi_implicit"}, {"step", 0.002}}},
      {"duration", 0.1},
  };
  switch (kind()) {
    case PluginKind::surface:
      scene["surface"] = use;
      scene["constraints"] = Json::array();  // its boundary has names that are not known here
      break;
    case PluginKind::shape:
      scene["surface"]["rest"] = use;
      break;
    case PluginKind::normal:
      scene["energies"] = Json::array({{{"plugin", "bending"}, {"xi", 1e-4}, {"normal", use}}});
      break;
    case PluginKind::energy:
      scene["energies"] = Json::array({use});
      break;
    case PluginKind::force:
      scene["forces"] = Json::array({use});
      break;
    case PluginKind::constraint:
      scene["constraints"] = Json::array({use});
      break;
    case PluginKind::collider:
      scene["colliders"] = Json::array({use});
      break;
    case PluginKind::integrator:
      // Held so that statics has an equilibrium, too, under a load that is no match for the sheet.
      scene["energies"].push_back({{"plugin", "bending_variational"}, {"xi", 1e-4}});
      scene["forces"][0]["acceleration"] = {0, 0, -0.01};
      scene["constraints"][0]["where"] = {{"box", {{-1, -1}, {0.13, 10}}}};
      if (!use.contains("step")) use["step"] = 0.002;
      scene["integrator"] = use;
      break;
    case PluginKind::solver:
      scene["solver"] = use;
      break;
    case PluginKind::output:
      scene["outputs"] = Json::array({use});
      break;
    case PluginKind::probe:
      scene["probes"] = Json::array({use});
      break;
  }
  return scene;
}

Scene Subject::scene(const Terrain& terrain) const {
  return read_scene_text(scene_json(terrain).dump(), kCheckedScene, std::filesystem::current_path(),
                         *registry_);
}

Simulation Subject::simulation(const Terrain& terrain) const { return {scene(terrain), registry_}; }

PluginUse Subject::use_in(const Scene& scene) const {
  switch (kind()) {
    case PluginKind::surface:
      return scene.surface;
    case PluginKind::shape:
      return scene.surface.parameters->get<PluginUse>("rest");
    case PluginKind::normal:
      return scene.energies.front().parameters->get<PluginUse>("normal");
    case PluginKind::energy:
      return scene.energies.front();
    case PluginKind::force:
      return scene.forces.front();
    case PluginKind::constraint:
      return scene.constraints.front();
    case PluginKind::collider:
      return scene.colliders.front().use;
    case PluginKind::integrator:
      return scene.integrator;
    case PluginKind::solver:
      return *scene.solver;
    case PluginKind::output:
      return scene.outputs.front().use;
    case PluginKind::probe:
      return scene.probes.front().use;
  }
  return {};
}

}  // namespace deform
