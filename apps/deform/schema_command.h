/// deform schema
#pragma once

#include <filesystem>

#include "deform/plugin/registry.h"

namespace deform::app {

/// Prints the JSON Schema of scenes; or, where a folder is given, writes it there as
/// scene.schema.json, and that of every plugin as plugins/KIND-NAME.schema.json. Returns the exit
/// code.
[[nodiscard]] int write_schemas(const PluginRegistry& registry,
                                const std::filesystem::path& folder);

}  // namespace deform::app
