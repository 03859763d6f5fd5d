#include "deform/compare/runner.h"

#include <algorithm>
#include <cstring>
#include <exception>
#include <map>
#include <mutex>
#include <numeric>
#include <optional>
#include <thread>
#include <utility>

#include <fmt/format.h>

#include "deform/error.h"
#include "deform/record/trajectory.h"

#include "compare/child_process.h"
#include "files/files.h"
#include "json/json.h"
#include "json/json_file.h"
#include "simulation/folder_lock.h"
#include "simulation/manifest.h"
#include "simulation/resumption.h"
#include "simulation/run_directory.h"
#include "simulation/scene_files.h"

namespace deform {
namespace {

namespace fs = std::filesystem;

std::string text_of(const Json& object, const char* key) {
  const auto found = object.find(key);
  return found != object.end() && found->is_string() ? found->get<std::string>() : "";
}

/// Of a run that was never begun.
constexpr const char* kRefused = "refused";

/// Whether an ended run's files are those that it wrote, and its states can be read.
bool is_whole(const fs::path& folder, const Json& manifest) {
  try {
    const fs::path trajectory = folder / kTrajectoryFile;
    if (!damaged_result(folder, manifest).empty()) return false;
    return !fs::exists(trajectory) || Trajectory(trajectory).frames() > 0;
  } catch (const Error&) {
    return false;
  }
}

/// What a run directory has of a planned run.
enum class Found : std::uint8_t { nothing, begun, complete };

/// Whether the run's own process would go on from what is there rather than refuse it, or begin
/// anew.
bool can_go_on(const PlannedRun& run, const fs::path& folder, const Manifest& planned) {
  try {
    return look_for_run(folder, run.scene, planned).checkpoint.has_value();
  } catch (const Error&) {
    return false;
  }
}

Found look_for(const PlannedRun& run, const fs::path& folder, const Manifest& planned) {
  if (fs::is_symlink(folder)) return Found::nothing;  // it would be written to elsewhere
  const Json manifest = read_json_object(folder / kManifestFile);
  const auto scene = read_file(folder / "scene.json");
  if (!manifest.is_object() || scene != scene_text(run.scene, folder)) return Found::nothing;
  if (!planned.difference(manifest).empty()) return Found::nothing;
  const std::string status = text_of(manifest, "status");
  // A divergence is a result, which comes again; a plugin may have failed for another reason.
  const bool complete = status == "done" || status == "diverged";
  const bool is_summed_up = read_json_object(folder / "summary.json").is_object();
  if (complete && is_summed_up)
    return is_whole(folder, manifest) ? Found::complete : Found::nothing;
  return can_go_on(run, folder, planned) ? Found::begun : Found::nothing;
}

/// Whatever an earlier comparison has left of a run: no figure of it is one of this comparison.
void discard(const fs::path& folder) {
  std::error_code error;
  std::optional<FolderLock> lock;
  if (fs::is_directory(fs::symlink_status(folder, error))) lock.emplace(folder);
  if (lock) require_unheld_within(folder);
  fs::remove_all(folder);
}

/// Of a run whose process came to no end of its own: a plugin may have ended it.
const char* status_without_summary(int code) {
  if (code == static_cast<int>(ExitCode::bad_input)) return kRefused;
  if (code == static_cast<int>(ExitCode::plugin_failed)) return status_of(ExitCode::plugin_failed);
  return "failed";
}

RunOutcome outcome_of(const fs::path& folder, const ChildExit& exit) {
  RunOutcome outcome;
  const Json summary = read_json_object(folder / "summary.json");
  // What plugins do to their process ends it with a code: a signal is somebody else's, who wants
  // the memory, say.
  outcome.is_failure = exit.signal != 0 || exit.code == static_cast<int>(ExitCode::internal_error);
  if (exit.signal != 0) {
    outcome.status = "crashed";
    outcome.reason = fmt::format("the program was killed by signal {} ({})", exit.signal,
                                 ::strsignal(exit.signal));
    if (!exit.said.empty()) outcome.reason += ": " + exit.said.substr(0, exit.said.find('\n'));
  } else if (summary.is_object() && !text_of(summary, "status").empty()) {
    outcome.status = text_of(summary, "status");
    outcome.reason = text_of(summary, "reason");
  } else {
    outcome.status = status_without_summary(exit.code);
    outcome.reason = exit.said.substr(0, exit.said.find_last_not_of('\n') + 1);
    if (outcome.reason.empty())
      outcome.reason = fmt::format("the program ended with code {} before the run did", exit.code);
  }
  return outcome;
}

Error changed_meanwhile(const std::string& name, const std::string& change) {
  return InputError(
      fmt::format("run {}: files changed while the comparison ran ({}); leave them alone until it "
                  "ends; --resume goes on from there",
                  name, change));
}

/// What the runs are to be made with, before the first one starts; nothing of those that are
/// refused. Throws InputError when a file changes meanwhile: runs share most of them.
std::vector<std::optional<Manifest>> planned_manifests(const std::vector<PlannedRun>& runs,
                                                       const PluginRegistry& registry) {
  std::vector<std::optional<Manifest>> manifests(runs.size());
  std::map<std::string, std::string> hashes;  // of each file
  for (std::size_t i = 0; i < runs.size(); ++i) {
    if (!runs[i].refused.empty()) continue;
    const Json& made_with = manifests[i].emplace(runs[i].scene, registry, RunOptions()).json();
    for (const char* kind : {"files", "plugins"}) {
      for (const Json& entry : made_with[kind]) {
        const std::string file = text_of(entry, "file"), hash = text_of(entry, "sha256");
        if (hashes.try_emplace(file, hash).first->second != hash)
          throw changed_meanwhile(runs[i].name, file);
      }
    }
  }
  return manifests;
}

/// Takes runs from a list, a worker thread and a process each.
class Runner {
 public:
  Runner(const std::vector<PlannedRun>& runs, const PluginRegistry& registry,
         const RunnerOptions& options)
      : runs_(runs),
        registry_(registry),
        options_(options),
        manifests_(planned_manifests(runs, registry)),
        outcomes_(runs.size()) {
    steps_done_.resize(runs.size());
    for (const PlannedRun& run : runs) total_steps_ += run.scene.steps();
  }

  std::vector<RunOutcome> execute() {
    std::vector<std::thread> workers;
    const auto jobs = std::min(static_cast<std::size_t>(std::max(options_.jobs, 1)), runs_.size());
    for (std::size_t i = 0; i < jobs; ++i) workers.emplace_back([this] { work(); });
    for (std::thread& worker : workers) worker.join();
    if (failure_) std::rethrow_exception(failure_);
    if (interrupted())
      throw Error(ExitCode::interrupted, "interrupted; --resume goes on from there");
    return std::move(outcomes_);
  }

 private:
  [[nodiscard]] bool interrupted() const {
    return options_.interrupted != nullptr && options_.interrupted->load();
  }

  void work() {
    for (std::size_t i = next_++; i < runs_.size() && !failed_ && !interrupted(); i = next_++) {
      try {
        outcomes_[i] = run(i);
        report(i, runs_[i].scene.steps());
      } catch (...) {
        const std::lock_guard lock(mutex_);
        if (!failed_.exchange(true)) failure_ = std::current_exception();
      }
    }
  }

  RunOutcome run(std::size_t i) {
    const PlannedRun& planned = runs_[i];
    const fs::path folder = options_.folder / planned.name;
    if (!planned.refused.empty()) {
      discard(folder);
      return {planned.plugin_failed ? status_of(ExitCode::plugin_failed) : kRefused,
              planned.refused};
    }
    require_unheld(folder);
    Found found = Found::nothing;
    if (options_.resume) found = look_for(planned, folder, *manifests_[i]);
    if (found == Found::complete) {
      RunOutcome outcome = outcome_of(folder, {});
      outcome.reused = true;
      return outcome;
    }
    if (found == Found::nothing) {
      discard(folder);
      make_run_directory(folder);
      write_atomically(folder / kManifestFile, planned_manifest());
      write_atomically(folder / "scene.json", scene_text(planned.scene, folder));
    } else {
      fs::remove(folder / "summary.json");  // not that of a run that ends without one
    }
    const ChildExit exit = run_child(
        options_.program.string(), arguments(folder),
        [&](const std::string& line) { return take(i, line); }, options_.interrupted);
    RunOutcome outcome = outcome_of(folder, exit);
    if (exit.code != static_cast<int>(ExitCode::interrupted)) require_as_planned(i, outcome);
    return outcome;
  }

  /// Throws InputError for a run that was made with something else than was planned: it is no
  /// result beside those of the others.
  void require_as_planned(std::size_t i, const RunOutcome& outcome) const {
    const bool is_result = outcome.status == status_of(ExitCode::done) ||
                           outcome.status == status_of(ExitCode::diverged);
    const std::string change = is_result ? manifests_[i]->difference(read_json_object(
                                               options_.folder / runs_[i].name / kManifestFile))
                                         : change_since(i);
    if (!change.empty()) throw changed_meanwhile(runs_[i].name, change);
  }

  /// "", or what is another now than when the run was planned. One that came to no result may not
  /// have come so far as to say what it was made with.
  [[nodiscard]] std::string change_since(std::size_t i) const {
    try {
      return manifests_[i]->difference(Manifest(runs_[i].scene, registry_, {}).json());
    } catch (const Error& e) {
      return e.what();  // a plugin file is gone
    }
  }

  [[nodiscard]] std::vector<std::string> arguments(const fs::path& folder) const {
    std::vector<std::string> all{"run",      (folder / "scene.json").string(),
                                 "--out",    folder.string(),
                                 "--resume", "--part-of-comparison"};
    all.insert(all.end(), options_.arguments.begin(), options_.arguments.end());
    return all;
  }

  /// "progress DONE": steps done. Warnings are in the run's log.txt; those on its scene are the
  /// comparison's, which has said them.
  bool take(std::size_t i, const std::string& line) {
    if (line.starts_with("deform: warning: ")) return true;
    constexpr std::string_view kProgress = "progress ";
    if (!line.starts_with(kProgress)) return false;
    if (options_.first_step) std::call_once(stepped_, options_.first_step);
    report(i, std::strtol(line.c_str() + kProgress.size(), nullptr, 10));
    return true;
  }

  void report(std::size_t i, long steps) {
    const std::lock_guard lock(mutex_);
    steps_done_[i] = steps;
    if (options_.progress)
      options_.progress(std::accumulate(steps_done_.begin(), steps_done_.end(), 0L), total_steps_);
  }

  const std::vector<PlannedRun>& runs_;
  const PluginRegistry& registry_;
  const RunnerOptions& options_;
  const std::vector<std::optional<Manifest>> manifests_;
  std::vector<RunOutcome> outcomes_;
  std::atomic<std::size_t> next_ = 0;
  std::atomic<bool> failed_ = false;
  std::exception_ptr failure_;
  std::once_flag stepped_;
  std::mutex mutex_;
  std::vector<long> steps_done_;
  long total_steps_ = 0;
};

}  // namespace

std::vector<RunOutcome> execute_runs(const std::vector<PlannedRun>& runs,
                                     const PluginRegistry& registry, const RunnerOptions& options) {
  return Runner(runs, registry, options).execute();
}

}  // namespace deform
