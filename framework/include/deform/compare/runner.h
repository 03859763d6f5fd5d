/// Runs of a comparison, each in a process of its own: what one of them does harms no other.
#pragma once

#include <atomic>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "deform/compare/plan.h"
#include "deform/export.h"

namespace deform {

/// How to run them.
struct RunnerOptions {
  std::filesystem::path program;       ///< the deform program, which runs each of them
  std::vector<std::string> arguments;  ///< of every run (plugin folders, threads)
  std::filesystem::path folder;        ///< of the comparison: a run's folder is named as the run
  int jobs = 1;                        ///< processes at a time
  /// Takes over runs in the folder that are complete and unchanged (scene, the files that it names,
  /// program, plugin files, results), and goes on from the checkpoints of those that are not
  /// complete; else what is there is replaced.
  bool resume = false;
  /// Called with the steps done and to do in all runs, from any thread, one call at a time.
  std::function<void(long done, long total)> progress;
  /// Called when the first step of any run was taken, from any thread.
  std::function<void()> first_step{};
  /// Ends all runs, each with a checkpoint, when it becomes true.
  const std::atomic<bool>* interrupted = nullptr;
};

/// How a run ended, as a comparison tells it.
struct RunOutcome {
  std::string status;   ///< of summary.json ("done", "diverged", …), "refused" or "crashed"
  std::string reason;   ///< empty when done
  bool reused = false;  ///< was there already
  /// Not of the simulation: a file could not be written, or a signal killed the process, say.
  bool is_failure = false;
};

/// Runs what is not there yet; one outcome a run, in their order. Throws Error when a process
/// cannot be started or a folder not be written; with ExitCode::interrupted when it was
/// interrupted; InputError, which names the run and what changed, where a run was not made with the
/// files, plugins and program that were there before the first one.
[[nodiscard]] DEFORM_API std::vector<RunOutcome> execute_runs(const std::vector<PlannedRun>& runs,
                                                              const PluginRegistry& registry,
                                                              const RunnerOptions& options);

}  // namespace deform
