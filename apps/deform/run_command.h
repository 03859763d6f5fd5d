/// deform run
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "deform/plugin/registry.h"
#include "deform/simulation/scene.h"

#include "progress.h"

namespace deform::app {

struct RunCommand {
  std::filesystem::path scene;
  std::vector<Replacement> replacements;
  std::string variant = "base";
  std::filesystem::path folder;  ///< empty: runs/SCENE or runs/SCENE-VARIANT
  bool force = false;
  bool resume = false;
  bool quiet = false;
  bool profile = false;
  /// Says to stdout how many steps are done, for the program that compares; nothing else.
  bool part_of_comparison = false;
  std::vector<std::string> command_line;
};

/// Runs the scene, shows how far it is, sums up. Returns the program's exit code; throws
/// deform::Error for what keeps a run from starting.
[[nodiscard]] int run_scene(const RunCommand& command,
                            const std::shared_ptr<const PluginRegistry>& registry,
                            ProgressBar& bar);

}  // namespace deform::app
