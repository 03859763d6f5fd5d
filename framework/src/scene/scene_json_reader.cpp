#include "scene/scene_json_reader.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <set>
#include <utility>
#include <variant>

#include "deform/model/materials.h"

#include "json/json_pointer.h"
#include "json/shown.h"
#include "plugin/value_json.h"
#include "scene/scene_rules.h"
#include "scene/value_reader.h"
#include "scene/velocity_reader.h"

namespace deform {
namespace {

using Form = SceneSection::Form;

constexpr const char* kMaterial = "material";
constexpr const char* kDensity = "density";

/// More steps than this no computer takes; it also keeps the count within its type.
constexpr double kMostSteps = 1e15;

bool is_normal(const ParameterValue& value) {
  const auto* use = std::get_if<PluginUse>(&value);
  return use != nullptr && use->kind == PluginKind::normal && !use->name.empty();
}

/// Whether an energy term was given a normal estimator, or has one by default.
bool takes_normal(const PluginUse& energy) {
  return energy.parameters != nullptr &&
         std::ranges::any_of(energy.parameters->entries(),
                             [](const auto& entry) { return is_normal(entry.second); });
}

/// Whether an energy names a sheet of the materials, which has a mass of its own.
bool names_material(const PluginUse& energy) {
  if (energy.parameters == nullptr || !energy.parameters->has("material")) return false;
  const auto* name = std::get_if<std::string>(&energy.parameters->at("material"));
  return name != nullptr && std::ranges::find(sheet_materials(), *name, &SheetMaterial::name) !=
                                sheet_materials().end();
}

/// The energy term with another normal estimator. What is wrong with the two together is wrong with
/// the shadow.
PluginUse with_normal(const PluginUse& energy, const PluginUse& normal) {
  ParameterValues values = *energy.parameters;
  for (const auto& [name, value] : energy.parameters->entries()) {
    if (is_normal(value)) values.set(name, normal);
  }
  return {energy.kind, energy.name, std::make_shared<const ParameterValues>(std::move(values)),
          normal.pointer};
}

/// Every one of the normal estimators with every energy term that takes one.
std::vector<ShadowUse> shadows_of(const std::vector<PluginUse>& normals,
                                  const std::vector<PluginUse>& energies) {
  std::vector<ShadowUse> shadows;
  std::set<std::string> names;
  for (const PluginUse& normal : normals) {
    std::string name = normal.name;
    for (int number = 2; !names.insert(name).second; ++number) {
      name = normal.name + '_' + std::to_string(number);
    }
    for (std::size_t term = 0; term < energies.size(); ++term) {
      if (!takes_normal(energies[term])) continue;
      shadows.push_back({name, normal, term, with_normal(energies[term], normal)});
    }
  }
  return shadows;
}

/// Reads the sections of a scene one by one, then makes the scene of them.
class SectionReader {
 public:
  SectionReader(Json& json, const PluginRegistry& registry, const std::filesystem::path& folder,
                SceneProblems& problems)
      : json_(json), problems_(problems), reader_(registry, folder, problems) {}

  Scene read() {
    std::vector<std::string> keys;
    for (const SceneSection& section : scene_sections()) {
      keys.push_back(section.key);
    }
    note_unknown_keys(json_, keys, "", "a scene", problems_);
    for (const SceneSection& section : scene_sections()) read(section);
    check_duration();
    check_shadows();
    return problems_.empty() ? scene() : sound_parts();
  }

 private:
  void read(const SceneSection& section) {
    switch (section.form) {
      case Form::note:
        return read_note(section);
      case Form::value:
        return reader_.member(json_, section.fields.front(), "", values_);
      case Form::object:
        return read_object(section);
      case Form::velocity:
        return read_initial_velocity(section);
      case Form::plugin:
        return read_plugin(section);
      case Form::plugins:
        return read_plugins(section);
      case Form::variants:
        json_.erase(section.key);
        return;
    }
  }

  void read_note(const SceneSection& section) {
    const auto found = json_.find(section.key);
    if (found == json_.end()) return;
    if (!found->is_string()) {
      problems_.add('/' + section.key, "found " + shown(*found) + ", expected text");
    }
    // It may be a path that starts from the scene's folder; the completed scene lies elsewhere.
    json_.erase(section.key);
  }

  void read_object(const SceneSection& section) {
    const std::string pointer = '/' + section.key;
    if (!json_.contains(section.key)) json_[section.key] = Json::object();
    Json& object = json_[section.key];
    if (section.key == kMaterial) density_is_given_ = object.contains(kDensity);
    if (!object.is_object()) {
      problems_.add(pointer, "found " + shown(object) + ", expected an object");
      return;
    }
    objects_[section.key] = reader_.members(object, section.fields, pointer, section.key);
    if (!section.of_run) json_.erase(section.key);
  }

  void read_initial_velocity(const SceneSection& section) {
    if (!json_.contains(section.key)) {
      json_[section.key] = to_json(section.fields.front().default_value);
    }
    PlainReader reader(problems_);
    if (auto velocity =
            read_velocity(json_[section.key], section.fields, '/' + section.key, reader)) {
      velocity_ = std::move(*velocity);
    }
  }

  void read_plugin(const SceneSection& section) {
    const auto found = json_.find(section.key);
    if (found != json_.end()) {
      uses_[section.key] = {reader_.plugin(*found, section.kind, '/' + section.key)};
    } else if (section.required) {
      problems_.add("", shown(section.key) + " is missing: the plugin to use");
    }
  }

  void read_plugins(const SceneSection& section) {
    const std::string pointer = '/' + section.key;
    if (!json_.contains(section.key)) json_[section.key] = Json::array();
    Json& array = json_[section.key];
    if (!array.is_array()) {
      problems_.add(pointer, "found " + shown(array) + ", expected a list of " +
                                 std::string(name_of(section.kind)) + " plugins");
      return;
    }
    if (array.size() > kMostPlugins) {
      problems_.add(pointer, "found " + std::to_string(array.size()) + " " + section.key +
                                 ", expected at most " + std::to_string(kMostPlugins));
      return;
    }
    auto& uses = uses_[section.key];
    for (std::size_t i = 0; i < array.size(); ++i) {
      uses.push_back(reader_.plugin(array[i], section.kind, child_pointer(pointer, i)));
    }
  }

  void check_duration() {
    const auto& integrator = uses_["integrator"];
    const bool has_step = !integrator.empty() && integrator.front().parameters != nullptr &&
                          integrator.front().parameters->has("step");
    if (!has_step || !values_.has("duration")) return;
    const double step = integrator.front().parameters->get<double>("step");
    const double steps = values_.get<double>("duration") / step;
    if (std::round(steps) < 1) {
      problems_.add("/duration", "found " + shown(json_["duration"]) +
                                     ", expected at least one step, which is " + shown(step) +
                                     " [s]");
    } else if (steps > kMostSteps) {
      problems_.add("/duration", "found " + shown(json_["duration"]) + ", which is more than " +
                                     shown(kMostSteps) + " steps of " + shown(step) + " [s]");
    }
  }

  void check_shadows() {
    const std::size_t shadows = uses_["shadow"].size();
    const auto& energies = uses_["energies"];
    const auto terms = static_cast<std::size_t>(std::ranges::count_if(energies, takes_normal));
    const bool terms_are_known = !problems_.any_within("/energies");
    if (shadows > 0 && terms == 0 && terms_are_known) {
      problems_.add("/shadow",
                    "no energy term of this scene takes a normal estimator: there is "
                    "nothing to shadow");
    } else if (shadows * terms > kMostShadows) {
      problems_.add("/shadow", "found " + std::to_string(shadows) + " shadows of " +
                                   std::to_string(terms) + " energy terms, expected at most " +
                                   std::to_string(kMostShadows) + " of all together");
    }
  }

  std::vector<ColliderUse> colliders() {
    std::vector<ColliderUse> colliders;
    for (PluginUse& use : uses_["colliders"]) {
      const auto friction = use.parameters->get<double>("friction");
      const auto thickness = use.parameters->get<double>("thickness");
      colliders.push_back({std::move(use), friction, thickness});
    }
    return colliders;
  }

  std::vector<RecorderUse> recorders(const std::string& key) {
    std::vector<RecorderUse> recorders;
    for (PluginUse& use : uses_[key]) {
      const auto every = use.parameters->get<std::int64_t>("every");
      recorders.push_back({std::move(use), every});
    }
    return recorders;
  }

  Material material() {
    const ParameterValues& values = objects_[kMaterial];
    return {
        .density = values.get<double>(kDensity),
        .damping = values.get<double>("damping"),
        .rayleigh_mass = values.get<double>("rayleigh_mass"),
        .rayleigh_stiffness = values.get<double>("rayleigh_stiffness"),
        .mass = values.get<std::string>("mass") == kParameters ? AreaOf::parameters : AreaOf::rest};
  }

  Scene scene() {
    Scene scene;
    scene.title = values_.get<std::string>("title");
    scene.surface = uses_["surface"].front();
    scene.material = material();
    scene.density_is_given = density_is_given_;
    scene.energies = uses_["energies"];
    // A default that does not hold must not be read as given when the scene is run again.
    if (!density_is_given_ && std::ranges::any_of(scene.energies, names_material))
      json_[kMaterial].erase(std::string(kDensity));
    scene.forces = uses_["forces"];
    scene.constraints = uses_["constraints"];
    scene.colliders = colliders();
    scene.integrator = uses_["integrator"].front();
    scene.step = scene.integrator.parameters->get<double>("step");
    scene.duration = values_.get<double>("duration");
    if (const auto& solver = uses_["solver"]; !solver.empty()) scene.solver = solver.front();
    scene.outputs = recorders("outputs");
    scene.probes = recorders("probes");
    scene.shadows = shadows_of(uses_["shadow"], scene.energies);
    scene.velocity = velocity_;
    scene.max_distance = objects_["limits"].get<double>("distance");
    scene.checkpoint_every = objects_["checkpoint"].get<std::int64_t>("every");
    scene.checkpoint_seconds = objects_["checkpoint"].get<double>("seconds");
    scene.reference = objects_["comparison"].get<std::string>("reference");
    scene.base_compared = objects_["comparison"].get<bool>("base");
    scene.tolerance = objects_["comparison"].get<double>("tolerance");
    scene.frames_written = objects_["frames"].get<bool>("write");
    scene.frames_every = objects_["frames"].get<std::int64_t>("every");
    scene.completed = json_.dump(2) + '\n';
    scene.files = reader_.files();
    return scene;
  }

  /// What nothing is wrong with, of a scene that has problems.
  Scene sound_parts() {
    const auto sound = [this](const std::string& key) {
      std::vector<PluginUse> uses = uses_[key];
      std::erase_if(uses, [this](const PluginUse& use) {
        return use.parameters == nullptr || problems_.any_within(use.pointer);
      });
      return uses;
    };
    const auto recorders_of = [](const std::vector<PluginUse>& uses) {
      std::vector<RecorderUse> recorders;
      recorders.reserve(uses.size());
      for (const PluginUse& use : uses) recorders.push_back({use});
      return recorders;
    };
    Scene scene;
    const std::vector<PluginUse> surface = sound("surface");
    if (surface.empty()) return scene;
    scene.surface = surface.front();
    scene.energies = sound("energies");
    scene.forces = sound("forces");
    scene.constraints = sound("constraints");
    for (const PluginUse& use : sound("colliders")) scene.colliders.push_back({use});
    scene.outputs = recorders_of(sound("outputs"));
    scene.probes = recorders_of(sound("probes"));
    if (!problems_.any_within("/shadow")) {
      scene.shadows = shadows_of(uses_["shadow"], scene.energies);
    }
    return scene;
  }

  bool density_is_given_ = false;
  Json& json_;
  SceneProblems& problems_;
  ValueReader reader_;
  ParameterValues values_;
  InitialVelocity velocity_;
  std::map<std::string, ParameterValues> objects_;
  std::map<std::string, std::vector<PluginUse>> uses_;
};

}  // namespace

Scene read_scene_json(Json& json, const PluginRegistry& registry,
                      const std::filesystem::path& folder, SceneProblems& problems) {
  if (!json.is_object()) {
    problems.add("", "found " + shown(json) + ", expected a scene, which is an object");
    return {};
  }
  return SectionReader(json, registry, folder, problems).read();
}

}  // namespace deform
