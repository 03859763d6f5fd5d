/// A run as it is recorded: from its first to its last file.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <exception>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "deform/error.h"
#include "deform/log.h"
#include "deform/simulation/run.h"
#include "deform/solve/step_times.h"

#include "json/json.h"
#include "plugin/process_end.h"
#include "profile/profile.h"
#include "record/trajectory_writer.h"
#include "simulation/balance_guards.h"
#include "simulation/checkpoint.h"
#include "simulation/held_folder.h"
#include "simulation/manifest.h"
#include "simulation/resumption.h"
#include "simulation/run_log.h"
#include "simulation/run_parts.h"
#include "simulation/step_advice.h"
#include "simulation/step_watch.h"

namespace deform {

/// One run from its first to its last file.
class Recording {
 public:
  /// Throws InputError when the scene or the checkpoint cannot be used; writes nothing.
  Recording(const Scene& scene, std::shared_ptr<const PluginRegistry> registry,
            const RunOptions& options, Manifest manifest, Resumption found, HeldFolder held,
            StepWatch& watch);
  RunResult execute();

 private:
  /// Of what has not been done yet: it may take long.
  static constexpr auto kUnknown = std::chrono::steady_clock::duration::max();
  /// What may take long.
  enum class Doing : std::uint8_t {
    beginning,
    checkpointing,
    recording,
    stepping,
    clearing,
    ending
  };
  /// What is known as one of these begins.
  struct Stock {
    Doing doing = Doing::beginning;
    long steps = 0;   // done
    double time = 0;  // after them [s]
    StepTimes times;
    std::vector<ColumnSummary> figures;
    std::string solver;
    const Checkpoint* fallback = nullptr;  // that may be written in place of the one in the folder
    bool has_old_run = false;
    RunResult result;
  };

  void load_checkpoint();
  void require_unchanged_files() const;
  void begin_folder();
  void start();
  void open_trajectory();
  void step_to_end();
  void step();
  /// What the run is at, and what is known as it begins: all that give_up may look at, as the main
  /// thread goes on meanwhile. To be called outside of the watch's spans.
  void take_stock(Doing doing);
  /// Does something under the watch, which gives it up when it goes on after a signal.
  template <class Action>
  void watched(Doing doing, const Action& action);
  /// What is being done never ends: the directory is finished without it, and the process left. In
  /// the watch's thread.
  void give_up() noexcept;
  /// Ends the outputs and closes the files as far as nobody is at work with them; returns the
  /// files.
  [[nodiscard]] std::vector<WrittenFile> leave_files(RunResult& result);
  /// What comes between two steps. Returns whether there is a next one.
  [[nodiscard]] bool settle();
  void save_checkpoint();
  void keep_checkpoint();
  [[nodiscard]] Checkpoint make_checkpoint();
  void write(const Checkpoint& checkpoint);
  /// Goes back to the last checkpoint: what comes after it is thrown away.
  void end_within(RunResult& result);
  void record(bool all_probes, bool all_outputs);
  [[nodiscard]] bool frame_due(long step) const;
  /// Whether anything is due after this step.
  [[nodiscard]] bool is_recorded(long step) const;
  /// Calls action(frame); what it makes the System compute counts as output, not as the model's
  /// time.
  template <class Action>
  void apart_from_model(const Action& action);
  template <class Action>
  void apart_from_model(const Frame& frame, const Action& action);
  static void end(RunResult& result, ExitCode code, const std::string& reason);
  void end_with(ExitCode code, const std::string& reason) { end(result_, code, reason); }
  void end_with(const Error& error);
  void finish();
  [[nodiscard]] std::vector<WrittenFile> close_files(RunResult& result);
  /// summary.json and manifest.json, from what is known.
  void conclude(RunResult& result, const std::vector<WrittenFile>& files);
  void write_profile();
  void keep_old_run(RunResult& result);
  /// For what comes after the end: a failure counts only where there was none before.
  template <class Action>
  static void and_also(RunResult& result, const Action& action);
  template <class Action>
  void and_also(const Action& action) {
    and_also(result_, action);
  }
  [[nodiscard]] Json summary(const RunResult& result) const;
  [[nodiscard]] bool interrupted() const {
    return options_.interrupted != nullptr && options_.interrupted->load();
  }
  [[nodiscard]] double stepping_seconds() const {
    if (!stepping_since_) return 0;
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - *stepping_since_)
        .count();
  }
  [[nodiscard]] double seconds() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - started_).count();
  }

  std::chrono::steady_clock::time_point started_ = std::chrono::steady_clock::now();
  const Scene& scene_;
  const RunOptions& options_;
  std::filesystem::path folder_;
  HeldFolder held_;
  Manifest manifest_;
  Resumption found_;
  RunParts parts_;
  std::vector<Problem> remarks_;
  std::optional<RunContext> context_;
  std::optional<RunLog> log_;
  std::optional<TrajectoryWriter> trajectory_;
  std::optional<Profile> profile_;
  StepTimes times_;  // of steps, and of recording as output
  CheckpointSchedule schedule_;
  BalanceGuards guards_;
  StepAdvice advice_;
  StepWatch& watch_;
  /// What to go on from if the step under way is thrown away; of long steps alone.
  std::optional<Checkpoint> before_step_;
  std::chrono::steady_clock::duration last_step_{0};  // recording included
  std::chrono::steady_clock::duration last_recording_ = kUnknown;
  std::optional<std::chrono::steady_clock::time_point> stepping_since_;
  Stock stock_;
  bool is_thrown_away_ = false;  // what came after the stock was taken
  bool is_given_up_ = false;
  std::optional<LastNote> last_note_;
  long frame_interval_;
  std::atomic<long> checkpoint_step_ = -1;    // of the checkpoint in the folder
  std::recursive_timed_mutex checkpointing_;  // while it is written
  std::optional<Diverged> divergence_;
  RunResult result_;
  BackgroundQueue writing_;  // the last: what its jobs look at outlives it
};

template <class Action>
void Recording::watched(Doing doing, const Action& action) {
  take_stock(doing);
  const std::function<void()> give_up = [this] { this->give_up(); };
  const StepWatch::Span span(watch_, give_up);
  action();
}

template <class Action>
void Recording::and_also(RunResult& result, const Action& action) {
  std::string failure;
  ExitCode code = ExitCode::internal_error;
  try {
    action();
    return;
  } catch (const Error& e) {
    failure = e.what();
    code = e.code();
  } catch (const std::exception& e) {
    failure = e.what();
  }
  if (result.code == ExitCode::done) {
    end(result, code, failure);
  } else {
    log::warn(failure);  // the first reason is the one that counts
  }
}

}  // namespace deform
