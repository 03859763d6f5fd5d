#include "check/subject.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <variant>

#include "deform/error.h"
#include "deform/model/energy_term.h"

#include "json/json_pointer.h"
#include "scene/scene_rules.h"

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

namespace {

/// Of the scene, where the plugin is none.
constexpr const char* kIntegrator = "semi_implicit";

/// Where a plugin of the kind stands in the scene that it is put into.
std::string place_of(PluginKind kind) {
  if (kind == PluginKind::shape) return "/surface/rest";
  if (kind == PluginKind::normal) return "/energies/0/normal";
  const SceneSection* const section = section_of(kind);
  if (section == nullptr) throw Error(ExitCode::internal_error, "a kind without a place");
  return section->pointer() + (section->form == SceneSection::Form::plugins ? "/0" : "");
}

/// The rest of the scene, where plugins of the kind need another one.
void suit(PluginKind kind, Json& scene) {
  switch (kind) {
    case PluginKind::surface:
      scene["constraints"] = Json::array();  // its boundary has names that are not known here
      return;
    case PluginKind::normal:
      scene["energies"][0] = {{"plugin", "bending"}, {"xi", 1e-4}};
      return;
    case PluginKind::integrator:
      // Held so that statics has an equilibrium, too, under a load that is no match for the sheet.
      scene["energies"].push_back({{"plugin", "bending_variational"}, {"xi", 1e-4}});
      scene["forces"][0]["acceleration"] = {0, 0, -0.01};
      scene["constraints"][0]["where"] = {{"box", {{-1, -1}, {0.13, 10}}}};
      return;
    default:
      return;
  }
}

/// The use at a place of the scene: this one, or one in its parameters.
const PluginUse* find_use(const PluginUse& use, const std::string& place) {
  if (use.pointer == place) return &use;
  if (use.parameters == nullptr || !is_within(place, use.pointer)) return nullptr;
  for (const auto& [name, value] : use.parameters->entries()) {
    const auto* const inner = std::get_if<PluginUse>(&value);
    if (inner == nullptr) continue;
    if (const PluginUse* const found = find_use(*inner, place)) return found;
  }
  return nullptr;
}

}  // namespace

Json Subject::scene_json(const Terrain& terrain, const std::string& integrator) const {
  constexpr double kStep = 0.002;
  Json scene{
      {"title", "check"},
      {"surface", terrain.surface},
      {"material", {{"density", 0.1}, {"damping", 0.1}}},
      {"energies", Json::array({{{"plugin", "stretching"}, {"eta", 0.01}}})},
      {"forces", Json::array({{{"plugin", "gravity"}, {"acceleration", {0, 0, -1}}}})},
      {"constraints", Json::array({{{"plugin", "pin"}, {"where", {{"boundary", "left"}}}}})},
      {"integrator", {{"plugin", integrator}}},
      {"duration", 0.1},
  };
  suit(kind(), scene);
  scene[Json::json_pointer(place_of(kind()))] = use();
  if (!scene["integrator"].contains("step")) scene["integrator"]["step"] = kStep;
  return scene;
}

Scene Subject::scene(const Terrain& terrain, const std::string& integrator) const {
  return read_scene_text(scene_json(terrain, integrator).dump(), kCheckedScene,
                         std::filesystem::current_path(), *registry_);
}

Scene Subject::scene(const Terrain& terrain) const { return scene(terrain, kIntegrator); }

/// Scalar unknowns without mass take one that solves with tangents.
std::string Subject::integrator_for(const Terrain& terrain) const {
  if (kind() != PluginKind::energy) return kIntegrator;
  const auto term = std::dynamic_pointer_cast<const TupleTerm>(make<EnergyTerm>(terrain).object);
  if (term == nullptr) return kIntegrator;
  const std::vector<ScalarUnknown> scalars = term->scalars();
  const bool is_massless =
      std::ranges::any_of(scalars, [](const ScalarUnknown& s) { return s.mass == 0; });
  return is_massless ? "backward_euler" : kIntegrator;
}

Simulation Subject::simulation(const Terrain& terrain) const {
  return {scene(terrain, integrator_for(terrain)), registry_};
}

PluginUse Subject::use_in(const Scene& scene) const {
  const std::string place = place_of(kind());
  for (const std::vector<PluginUse>& uses : scene.plugins.values)
    for (const PluginUse& use : uses)
      if (const PluginUse* const found = find_use(use, place)) return *found;
  throw Error(ExitCode::internal_error, "the scene of the check names no plugin at " + place);
}

}  // namespace deform
