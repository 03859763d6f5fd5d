/// A recorded run: the simulation loop and its run directory.
#pragma once

#include <atomic>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "deform/error.h"
#include "deform/export.h"
#include "deform/simulation/simulation.h"
#include "deform/solve/step_times.h"

namespace deform {

struct RunResult {
  ExitCode code = ExitCode::done;
  std::string reason;  ///< empty when done
  long steps = 0;
  long resumed_after = 0;  ///< of these, the steps that were done before the run was resumed
  double wall_seconds = 0;
  StepTimes times;
  std::vector<std::pair<std::string, double>>
      figures;  ///< the last row of the probes, header and value
  double stepping_seconds =
      0;                ///< of wall_seconds: from the first step to the last, recording included
  std::string profile;  ///< the table of profile.txt; empty unless asked for
  /// The run took no step, and the one that it was to replace (RunOptions::force) is still there.
  bool kept_old_run = false;
};

struct RunOptions {
  std::filesystem::path folder;  ///< the run directory; made, must not exist unless `force`
  /// Goes on from the checkpoint in the folder, to the same bits as without interruption; where
  /// there is none, starts anew with a warning. `force` does not count then.
  bool resume = false;
  bool force = false;  ///< replace an existing run directory
  /// Also writes where the time of the steps went: profile.txt, a table, and trace.json, for
  /// chrome://tracing and Perfetto. Changes no other result.
  bool profile = false;
  /// Called after each step with the steps done and to do.
  std::function<void(long done, long total)> progress;
  /// Ends the run when it becomes true: after the step under way if that ends within half a second;
  /// else the step is thrown away, and the run ends at its last checkpoint. So it does where what
  /// is recorded takes too long.
  const std::atomic<bool>* interrupted = nullptr;
  /// Called, in place of a return, from another thread, where a step, a probe or an output goes on
  /// for 1.5 s though the run was told to end: in a factorisation that cannot be stopped, say, or
  /// in a plugin that hangs. The run directory can be resumed then. It must end the process, in
  /// which the step still goes on. Empty: the run waits.
  std::function<void(const RunResult&)> abandon{};
  std::vector<std::string> command_line;  ///< for the manifest
  std::string commit{};                   ///< of the program's sources, for the manifest
};

/// How a run ended: "done", "diverged", "plugin failed", "interrupted" or "failed".
[[nodiscard]] DEFORM_API const char* status_of(ExitCode code);

/// Makes everything that a run of the scene is made of, runs nothing and writes nothing. Throws
/// InputError with every problem found, as `run` would before it writes anything. Returns what is
/// no error, though the user may not have meant it; `run` puts the same into the log.
DEFORM_API std::vector<Problem> check(const Scene& scene,
                                      std::shared_ptr<const PluginRegistry> registry);

/// Runs a scene to its end and writes the run directory: scene.json, manifest.json, probes.csv,
/// summary.json, log.txt and the outputs. Divergence, interruption and plugin failures are results
/// (see `code`), bad input throws InputError before anything is written.
[[nodiscard]] DEFORM_API RunResult run(const Scene& scene,
                                       std::shared_ptr<const PluginRegistry> registry,
                                       const RunOptions& options);

}  // namespace deform
