/// The plugin that is being checked, and small worlds to put it into.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "deform/plugin/registry.h"
#include "deform/simulation/simulation.h"

#include "check/checks.h"
#include "json/json.h"
#include "simulation/part_maker.h"

namespace deform {

/// What the scenes that the plugin is put into are called in messages.
inline constexpr const char* kCheckedScene = "the scene of the check";

/// A grid with one of its schemes and a rest shape.
struct Terrain {
  std::string name;
  Json surface;
  bool one_frame = true;  ///< one consistent frame: gradients are exact there
};
/// Flat, arc and sphere patch, each with forward, central and symmetric differences and with the
/// paper's border; n1 × n2 nodes.
[[nodiscard]] std::vector<Terrain> terrains(int n1, int n2);

/// One object of the plugin, with the surface that it was made for.
template <class Interface>
struct Made {
  std::shared_ptr<const Surface> surface;
  std::shared_ptr<Interface> object;
};

class Subject {
 public:
  Subject(std::shared_ptr<const PluginRegistry> registry, const LoadedPlugin& plugin,
          Json parameters)
      : registry_(std::move(registry)), plugin_(plugin), parameters_(std::move(parameters)) {}

  [[nodiscard]] const LoadedPlugin& plugin() const { return plugin_; }
  [[nodiscard]] PluginKind kind() const { return plugin_.file().kind; }
  [[nodiscard]] const std::shared_ptr<const PluginRegistry>& registry() const { return registry_; }

  /// The plugin as a scene says it, with its parameters.
  [[nodiscard]] Json use() const;
  /// A scene on a terrain with the plugin in its place: gravity pulls at a sheet that is held at
  /// its left side, where the plugin does not stand for any of that. Throws InputError for
  /// parameters that it rejects.
  [[nodiscard]] Scene scene(const Terrain& terrain) const;
  [[nodiscard]] Simulation simulation(const Terrain& terrain) const;
  /// The plugin's object alone, as that scene describes it.
  template <class Interface>
  [[nodiscard]] Made<Interface> make(const Terrain& terrain) const;

 private:
  [[nodiscard]] Json scene_json(const Terrain& terrain, const std::string& integrator) const;
  [[nodiscard]] Scene scene(const Terrain& terrain, const std::string& integrator) const;
  [[nodiscard]] std::string integrator_for(const Terrain& terrain) const;
  [[nodiscard]] PluginUse use_in(const Scene& scene) const;

  std::shared_ptr<const PluginRegistry> registry_;
  const LoadedPlugin& plugin_;
  Json parameters_;
};

template <class Interface>
Made<Interface> Subject::make(const Terrain& terrain) const {
  const Scene described = scene(terrain);
  PartMaker maker(described, registry_);
  auto surface = maker.make<Surface>(described.surface(), maker.setup());
  maker.throw_problems();
  if constexpr (std::is_same_v<Interface, Surface>) return {surface->object, surface->object};
  const NodeValues areas = areas_of_mass(*surface->object, described.material);
  auto made = maker.make<Interface>(use_in(described),
                                    maker.setup(*surface->object, surface->object->rest(), areas));
  maker.throw_problems();
  return {surface->object, made->object};
}

}  // namespace deform
