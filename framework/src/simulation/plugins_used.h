/// The plugins that take part in a run.
#pragma once

#include <vector>

#include "deform/plugin/registry.h"
#include "deform/simulation/scene.h"

namespace deform {

/// Every plugin that a scene names, defaults of parameters included, and the solvers that it may
/// get; each once, by kind and name.
[[nodiscard]] std::vector<const LoadedPlugin*> plugins_used(const Scene& scene,
                                                            const PluginRegistry& registry);

}  // namespace deform
