/// deform validate
#pragma once

#include <filesystem>
#include <memory>
#include <vector>

#include "deform/plugin/registry.h"

namespace deform::app {

/// Checks scenes with all of their variants and everything that they name; runs nothing and writes
/// no file. Prints "FILE: ok (N variants)", or all problems of the file to stderr. Returns the
/// largest exit code of any of them.
[[nodiscard]] int validate_scenes(const std::vector<std::filesystem::path>& files,
                                  const std::shared_ptr<const PluginRegistry>& registry);

}  // namespace deform::app
