/// What a comparison runs: variants of one scene, and grids of values.
#pragma once

#include <atomic>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "deform/export.h"
#include "deform/plugin/registry.h"
#include "deform/simulation/scene.h"

namespace deform {

/// Values to try one after another at a JSON pointer (`--vary PTR=V1,V2,…`); each is JSON, else a
/// string.
struct Variation {
  std::string pointer;
  std::vector<std::string> values;
};

/// Splits "V1,V2,…" at commas that are outside of quotes and brackets.
[[nodiscard]] DEFORM_API std::vector<std::string> split_values(const std::string& text);

/// What is compared.
struct ComparisonRequest {
  std::filesystem::path scene;
  std::vector<Replacement> replacements;  ///< made to every run
  std::vector<Variation> variations;      ///< their full grid, over each of the variants
  /// Of the scene; empty: all, the base first; with variations the base alone.
  std::vector<std::string> variants;
  /// A run's name, "refined" or "refined:VARIANT". Empty: as the scene says; if that is no run, the
  /// one that changes nothing, else the first.
  std::string reference;
  double tolerance = 0;  ///< distance at which runs part [m]; 0: as the scene says
};

/// A run of a comparison.
struct PlannedRun {
  std::string name;  ///< unique; a folder's name
  Scene scene;
  std::string refused{};       ///< why it cannot be run: what showed when its parts were made
  bool plugin_failed = false;  ///< then: a plugin threw, rather than the scene was wrong
  /// Names of its probes' columns; empty of a run that is refused.
  std::vector<std::string> columns{};
};

struct ComparisonPlan {
  std::vector<PlannedRun> runs;  ///< in the order of the file and of the values
  std::string reference;         ///< a run's name
  std::string base;  ///< the scene without variants and variations, complete, as JSON text
  std::vector<SceneFile> base_files{};  ///< that it names
};

/// The name of the run with the finer grid.
inline constexpr const char* kRefined = "refined";
/// More runs than these nobody looks at.
inline constexpr std::size_t kMostRuns = 1000;

/// Reads and checks everything that is to be run. Throws InputError with every problem of the scene
/// and of what replaces its values; what only shows when a run's parts are made (a force that no
/// node takes) is a refused run, unless all are. These parts are made in child processes, unless
/// this one has several threads already: a plugin that ends the process is a run with its reason.
/// Throws Error with ExitCode::interrupted when `interrupted` becomes true.
[[nodiscard]] DEFORM_API ComparisonPlan plan_comparison(
    const ComparisonRequest& request, const std::shared_ptr<const PluginRegistry>& registry,
    const std::atomic<bool>* interrupted = nullptr);

}  // namespace deform
