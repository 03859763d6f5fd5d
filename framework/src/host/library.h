#pragma once

#include <filesystem>
#include <optional>

#include "deform/plugin/registry.h"

namespace deform {

/// What a library's file name KIND-NAME.so says that it holds; nothing for other names.
std::optional<PluginFile> plugin_file(const std::filesystem::path& path);

}  // namespace deform
