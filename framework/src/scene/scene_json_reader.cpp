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
#include "plugin/common_parameters.h"
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
    for (const SceneSection& section : scene_sections()) keys.push_back(section.key());
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
        return reader_.member(json_, section.fields().front(), "", values_);
      case Form::object:
        return read_object(section);
      case Form::velocity:
        return read_initial_velocity(section);
      case Form::plugin:
        return read_plugin(section);
      case Form::plugins:
        plugins_[section.kind] = read_plugins(section);
        return;
      case Form::shadows:
        shadowing_ = read_plugins(section);
        return;
      case Form::variants:
        json_.erase(section.key());
        return;
    }
  }

  void read_note(const SceneSection& section) {
    const auto found = json_.find(section.key());
    if (found == json_.end()) return;
    if (!found->is_string()) {
      problems_.add(section.pointer(), "found " + shown(*found) + ", expected text");
    }
    // It may be a path that starts from the scene's folder; the completed scene lies elsewhere.
    json_.erase(section.key());
  }

  void read_object(const SceneSection& section) {
    const std::string key = section.key(), pointer = section.pointer();
    if (!json_.contains(key)) json_[key] = Json::object();
    Json& object = json_[key];
    if (key == kMaterial) density_is_given_ = object.contains(kDensity);
    if (!object.is_object()) {
      problems_.add(pointer, "found " + shown(object) + ", expected an object");
      return;
    }
    objects_[key] = reader_.members(object, section.fields(), pointer, key);
    if (!section.of_run) json_.erase(key);
  }

  void read_initial_velocity(const SceneSection& section) {
    const std::string key = section.key();
    if (!json_.contains(key)) json_[key] = to_json(section.fields().front().default_value);
    PlainReader reader(problems_);
    if (auto velocity = read_velocity(json_[key], section.fields(), section.pointer(), reader)) {
      velocity_ = std::move(*velocity);
    }
  }

  void read_plugin(const SceneSection& section) {
    const auto found = json_.find(section.key());
    if (found != json_.end()) {
      plugins_[section.kind] = {reader_.plugin(*found, section.kind, section.pointer())};
    } else if (section.required) {
      problems_.add("", shown(section.key()) + " is missing: the plugin to use");
    }
  }

  std::vector<PluginUse> read_plugins(const SceneSection& section) {
    const std::string key = section.key(), pointer = section.pointer();
    if (!json_.contains(key)) json_[key] = Json::array();
    Json& array = json_[key];
    if (!array.is_array()) {
      problems_.add(pointer, "found " + shown(array) + ", expected a list of " +
                                 std::string(name_of(section.kind)) + " plugins");
      return {};
    }
    if (array.size() > kMostPlugins) {
      problems_.add(pointer, "found " + std::to_string(array.size()) + " " + key +
                                 ", expected at most " + std::to_string(kMostPlugins));
      return {};
    }
    std::vector<PluginUse> uses;
    for (std::size_t i = 0; i < array.size(); ++i) {
      uses.push_back(reader_.plugin(array[i], section.kind, child_pointer(pointer, i)));
    }
    return uses;
  }

  /// [s]; 0 where there is none that could be read.
  [[nodiscard]] double integrator_step() const {
    const auto& integrators = plugins_[PluginKind::integrator];
    return integrators.empty() ? 0 : common_parameters<Integrator>(integrators.front()).step;
  }

  void check_duration() {
    const double step = integrator_step();
    if (step == 0 || !values_.has("duration")) return;
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
    const std::size_t shadows = shadowing_.size();
    const auto& energies = plugins_[PluginKind::energy];
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
    const auto& energies = plugins_[PluginKind::energy];
    scene.material = material();
    scene.density_is_given = density_is_given_;
    // A default that does not hold must not be read as given when the scene is run again.
    if (!density_is_given_ && std::ranges::any_of(energies, names_material))
      json_[kMaterial].erase(std::string(kDensity));
    scene.step = integrator_step();
    scene.duration = values_.get<double>("duration");
    scene.shadows = shadows_of(shadowing_, energies);
    scene.plugins = std::move(plugins_);
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
    Scene scene;
    for (std::vector<PluginUse>& uses : plugins_.values) {
      std::erase_if(uses, [this](const PluginUse& use) {
        return use.parameters == nullptr || problems_.any_within(use.pointer);
      });
    }
    if (!problems_.any_within("/shadow")) {
      scene.shadows = shadows_of(shadowing_, plugins_[PluginKind::energy]);
    }
    scene.plugins = std::move(plugins_);
    return scene;
  }

  bool density_is_given_ = false;
  Json& json_;
  SceneProblems& problems_;
  ValueReader reader_;
  ParameterValues values_;
  InitialVelocity velocity_;
  std::map<std::string, ParameterValues> objects_;
  PerKind<std::vector<PluginUse>> plugins_;  // that take part in the run
  std::vector<PluginUse> shadowing_;
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
