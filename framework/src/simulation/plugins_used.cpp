#include "simulation/plugins_used.h"

#include <map>
#include <utility>
#include <variant>

#include "simulation/solver_uses.h"

namespace deform {
namespace {

class Collector {
 public:
  explicit Collector(const PluginRegistry& registry) : registry_(registry) {}

  void add(const PluginUse& use) {
    if (use.name.empty()) return;  // an optional plugin that is not there
    const LoadedPlugin& plugin = registry_.load(use.kind, use.name);
    found_[{use.kind, use.name}] = &plugin;
    for (const ParameterField& field : plugin.fields()) {
      const bool given = use.parameters && use.parameters->has(field.name);
      const ParameterValue& value = given ? use.parameters->at(field.name) : field.default_value;
      if (const auto* inner = std::get_if<PluginUse>(&value)) add(*inner);
    }
  }
  void add(const std::vector<PluginUse>& uses) {
    for (const PluginUse& use : uses) add(use);
  }

  [[nodiscard]] std::vector<const LoadedPlugin*> found() const {
    std::vector<const LoadedPlugin*> plugins;
    for (const auto& [key, plugin] : found_) plugins.push_back(plugin);
    return plugins;
  }

 private:
  const PluginRegistry& registry_;
  std::map<std::pair<PluginKind, std::string>, const LoadedPlugin*> found_;
};

}  // namespace

std::vector<const LoadedPlugin*> plugins_used(const Scene& scene, const PluginRegistry& registry) {
  Collector collector(registry);
  for (const std::vector<PluginUse>& uses : scene.plugins.values) collector.add(uses);
  collector.add(solver_uses(scene, registry).uses);
  for (const ShadowUse& shadow : scene.shadows) collector.add(shadow.normal);
  return collector.found();
}

}  // namespace deform
