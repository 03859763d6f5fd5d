/// deform mesh
#pragma once

#include <filesystem>
#include <memory>
#include <vector>

#include "deform/plugin/registry.h"

namespace deform::app {

/// Prints what the surface "mesh" sees in files: counts, borders, extent, quality, curvature; and
/// what it mended, if it may (`repair`). Runs nothing and writes no file. Returns the largest exit
/// code of any of them.
[[nodiscard]] int describe_meshes(const std::vector<std::filesystem::path>& files, bool repair,
                                  const PluginRegistry& registry);

}  // namespace deform::app
