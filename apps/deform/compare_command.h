/// deform compare
#pragma once

#include <memory>

#include "deform/compare/comparison.h"

#include "progress.h"

namespace deform::app {

struct CompareCommand {
  ComparisonOptions options;
  std::vector<std::string> variants;  ///< as on the command line: names with commas between
  int threads = 0;                    ///< of each run; 0: those of the machine over the jobs
  bool quiet = false;
};

/// Runs the comparison, shows how far it is, prints the table. Returns the program's exit code; 0
/// also when runs diverged or failed, which is a result; throws deform::Error for what keeps the
/// comparison from starting.
[[nodiscard]] int compare_scene(CompareCommand command,
                                const std::vector<std::filesystem::path>& plugin_folders,
                                const std::shared_ptr<const PluginRegistry>& registry,
                                ProgressBar& bar);

}  // namespace deform::app
