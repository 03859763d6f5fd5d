#include "deform/simulation/run.h"

#include <chrono>
#include <cstddef>
#include <exception>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "deform/log.h"

#include "profile/profile.h"
#include "record/trajectory_writer.h"
#include "scene/json.h"
#include "simulation/checkpoint.h"
#include "simulation/files.h"
#include "simulation/manifest.h"
#include "simulation/memory_sections.h"
#include "simulation/resumption.h"
#include "simulation/run_directory.h"
#include "simulation/run_log.h"
#include "simulation/run_parts.h"
#include "solve/not_finite.h"
#include "solve/stopwatch.h"

namespace deform {
namespace {

/// Where a checkpoint keeps how long the trajectory was.
constexpr const char* kTrajectoryBytes = "trajectory/bytes";
/// What a profiled run leaves in its directory.
constexpr const char *kProfileTable = "profile.txt", *kProfileTrace = "trace.json";

std::size_t trajectory_bytes(const Checkpoint& checkpoint) {
  const double bytes = checkpoint.memory.get(kTrajectoryBytes, 1).front();
  if (!(bytes > 0 && bytes < 0x1p53)) throw InputError("its length of the trajectory is not one");
  return static_cast<std::size_t>(bytes);
}

/// One run from its first to its last file.
class Recording {
 public:
  /// Throws InputError when the scene or the checkpoint cannot be used; writes nothing.
  Recording(const Scene& scene, std::shared_ptr<const PluginRegistry> registry,
            const RunOptions& options, Resumption found);
  RunResult execute();

 private:
  void load_checkpoint();
  void prepare_folder();
  void start();
  void open_trajectory();
  void step_to_end();
  /// What comes between two steps. Returns whether there is a next one.
  [[nodiscard]] bool settle();
  void save_checkpoint();
  void record(bool all_probes, bool all_outputs);
  [[nodiscard]] bool frame_due(long step) const;
  /// Calls action(frame); what it makes the System compute counts as output, not as the model's
  /// time.
  template <class Action>
  void apart_from_model(const Action& action);
  void end_with(ExitCode code, const std::string& reason);
  void end_with(const Error& error);
  void finish();
  void write_profile();
  /// For what comes after the end: a failure counts only where there was none before.
  template <class Action>
  void and_also(const Action& action);
  [[nodiscard]] Json summary() const;
  [[nodiscard]] bool interrupted() const {
    return options_.interrupted != nullptr && options_.interrupted->load();
  }
  [[nodiscard]] double seconds() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - started_).count();
  }

  std::chrono::steady_clock::time_point started_ = std::chrono::steady_clock::now();
  const Scene& scene_;
  const RunOptions& options_;
  std::filesystem::path folder_;
  Resumption found_;
  RunParts parts_;
  std::optional<RunContext> context_;
  Manifest manifest_;
  std::optional<TrajectoryWriter> trajectory_;
  std::optional<Profile> profile_;
  CheckpointSchedule schedule_;
  long checkpoint_step_ = -1;  // of the checkpoint in the folder
  std::optional<Diverged> divergence_;
  RunResult result_;
  BackgroundQueue writing_;  // the last: what its jobs look at outlives it
};

Recording::Recording(const Scene& scene, std::shared_ptr<const PluginRegistry> registry,
                     const RunOptions& options, Resumption found)
    : scene_(scene),
      options_(options),
      folder_(std::filesystem::absolute(options.folder)),
      found_(std::move(found)),
      parts_(make_run_parts(scene, registry)),
      manifest_(scene, *registry, options),
      schedule_(scene) {
  context_.emplace(make_run_context(parts_, folder_));
  if (found_.checkpoint) context_->resumed_at = found_.checkpoint->step;
  begin_probes(parts_, *context_);  // may still reject the scene, so comes before the folder
  if (found_.checkpoint) load_checkpoint();
  if (options_.profile) profile_.emplace();
}

void Recording::load_checkpoint() {
  const Checkpoint& checkpoint = *found_.checkpoint;
  try {
    load_section(*parts_.simulation, "simulation", checkpoint.memory);
    if (parts_.simulation->steps() != checkpoint.step)
      throw InputError("its numbers of steps are two");
    parts_.probes->load(checkpoint.memory);
    if (scene_.frames_written) (void)trajectory_bytes(checkpoint);
  } catch (const InputError& e) {
    throw InputError(
        fmt::format("cannot resume from {}: {}", checkpoint_file(folder_).string(), e.what()));
  }
  checkpoint_step_ = result_.resumed_after = checkpoint.step;
}

void Recording::prepare_folder() {
  if (found_.checkpoint) {
    remove_half_written(folder_);
  } else {
    make_run_directory(folder_);
  }
  manifest_.write(folder_);  // first: from here on the folder is known as one of ours
}

RunResult Recording::execute() {
  prepare_folder();
  const RunLog log(folder_ / "log.txt", found_.checkpoint.has_value());
  log::info(fmt::format("run '{}': {} steps of {} s", scene_.title, scene_.steps(), scene_.step));
  if (found_.checkpoint) {
    log::info(fmt::format("resumed after step {}", checkpoint_step_));
    manifest_.resume(checkpoint_step_, found_.manifest);
    manifest_.write(folder_);
  } else if (options_.resume && !found_.planned) {
    log::warn(fmt::format("there is no checkpoint in {}: the run starts anew", folder_.string()));
  }
  for (const Problem& remark : remarks_on(parts_)) log::warn(remark.message);
  write_atomically(folder_ / "scene.json", scene_.completed);
  try {
    for (const std::string& note : parts_.simulation->system().notes()) log::info(note);
    start();
    const Profile::Active active(profile_ ? &*profile_ : nullptr);
    const Stopwatch watch(result_.stepping_seconds, "run");
    step_to_end();
  } catch (const Diverged& e) {
    divergence_ = e;
    end_with(e);
  } catch (const Error& e) {
    end_with(e);
  } catch (const std::exception& e) {
    end_with(ExitCode::internal_error, e.what());
  }
  finish();
  return std::move(result_);
}

void Recording::start() {
  parts_.probes->open(folder_ / "probes.csv",
                      found_.checkpoint ? found_.checkpoint->table_bytes : 0);
  if (scene_.frames_written) open_trajectory();
  parts_.outputs->begin(*context_);
  if (found_.checkpoint) parts_.outputs->load(found_.checkpoint->memory);
}

void Recording::open_trajectory() {
  const std::size_t keep = found_.checkpoint ? trajectory_bytes(*found_.checkpoint) : 0;
  Simulation& simulation = *parts_.simulation;
  trajectory_.emplace(folder_ / kTrajectoryFile, simulation.system(), simulation.size(), keep);
}

void Recording::step_to_end() {
  Simulation& simulation = *parts_.simulation;
  while (settle()) {
    simulation.step();
    if (!parts_.probes->none()) {
      apart_from_model([this](const Frame& frame) { parts_.probes->follow(frame); });
    }
    if (profile_) profile_->end_step();
    if (options_.progress) options_.progress(simulation.steps(), scene_.steps());
  }
}

bool Recording::settle() {
  const long step = parts_.simulation->steps(), total = scene_.steps();
  const bool last = step == total;
  const bool stop = !last && interrupted();
  // Before the recording: see Checkpoint. The last one serves who prolongs the run.
  if (last || stop || schedule_.due(step)) save_checkpoint();
  // A row too many goes when the run is resumed; a frame's files would stay.
  record(last || stop, last);
  if (stop) {
    end_with(
        ExitCode::interrupted,
        fmt::format("interrupted after {} of {} steps; --resume goes on from there", step, total));
  }
  return !last && !stop;
}

void Recording::save_checkpoint() {
  Simulation& simulation = *parts_.simulation;
  if (checkpoint_step_ == simulation.steps()) return;
  const Stopwatch watch(simulation.system().times().output, "checkpoint");
  writing_.drain();  // files of earlier steps are there before what relies on them
  Checkpoint checkpoint;
  checkpoint.scene = identity_of(scene_);
  checkpoint.step = simulation.steps();
  checkpoint.table_bytes = parts_.probes->sync();  // on disk before what relies on it
  save_section(simulation, "simulation", checkpoint.memory);
  parts_.probes->save(checkpoint.memory);
  parts_.outputs->save(checkpoint.memory);
  if (trajectory_) {
    checkpoint.memory.put(kTrajectoryBytes, {static_cast<double>(trajectory_->sync())});
  }
  write_checkpoint(folder_, checkpoint);
  checkpoint_step_ = checkpoint.step;
  schedule_.restart();
}

template <class Action>
void Recording::apart_from_model(const Action& action) {
  const Frame frame = parts_.simulation->frame();
  const StepTimes model = frame.system.times();
  const double before = seconds();
  try {
    action(frame);
  } catch (const NotFinite& e) {
    throw e.at_step(frame.step, "recording");
  }
  frame.system.times() = model;
  frame.system.times().output += seconds() - before;
}

bool Recording::frame_due(long step) const {
  return trajectory_.has_value() && step % scene_.frame_interval() == 0;
}

void Recording::record(bool all_probes, bool all_outputs) {
  const long step = parts_.simulation->steps();
  const bool due =
      step == 0 || parts_.probes->due(step) || parts_.outputs->due(step) || frame_due(step);
  if (!due && !all_probes && !all_outputs) return;
  writing_.require_success();  // rather before a frame than within it
  apart_from_model([&](const Frame& frame) {
    parts_.probes->record(frame, all_probes);
    parts_.outputs->record(frame, all_outputs, writing_);
    if (trajectory_ && (all_outputs || frame_due(frame.step))) {
      const Span span("trajectory");
      trajectory_->record(frame);
    }
  });
}

void Recording::end_with(ExitCode code, const std::string& reason) {
  result_.code = code;
  result_.reason = reason;
  log::info(fmt::format("the run ends: {}", reason));
}

void Recording::end_with(const Error& error) {
  const bool names_step = error.code() == ExitCode::diverged;
  end_with(error.code(), names_step ? error.what()
                                    : fmt::format("{} (after step {})", error.what(),
                                                  parts_.simulation->steps()));
}

template <class Action>
void Recording::and_also(const Action& action) {
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
  if (result_.code == ExitCode::done) {
    end_with(code, failure);
  } else {
    log::warn(failure);  // the first reason is the one that counts
  }
}

void Recording::finish() {
  if (divergence_ && divergence_->step() > parts_.simulation->steps()) {
    and_also([this] { record(true, true); });  // the last good state
  }
  and_also([this] { writing_.drain(); });
  and_also([this] { parts_.outputs->end(); });
  if (profile_) and_also([this] { write_profile(); });

  Simulation& simulation = *parts_.simulation;
  result_.steps = simulation.steps();
  result_.times = simulation.system().times();
  result_.times.steps = simulation.steps() - result_.resumed_after;
  const auto& columns = parts_.probes->columns();
  for (std::size_t i = 0; i < columns.size(); ++i) {
    result_.figures.emplace_back(header_of(columns[i]), parts_.probes->summaries()[i].last);
  }
  and_also([this] {
    write_atomically(folder_ / "summary.json",
                     summary().dump(2, ' ', false, Json::error_handler_t::replace) + '\n');
  });
  result_.wall_seconds = seconds();
  log::info(fmt::format("{} after {} steps and {:.3f} s", status_of(result_.code), result_.steps,
                        result_.wall_seconds));
  manifest_.finish(result_, simulation.system().solver_choice());
  and_also([this] { manifest_.write(folder_); });
}

void Recording::write_profile() {
  result_.profile = profile_->table();
  write_atomically(folder_ / kProfileTable, result_.profile);
  write_atomically(folder_ / kProfileTrace, profile_->trace());
}

Json Recording::summary() const {
  Json json;
  json["status"] = status_of(result_.code);
  json["exit_code"] = static_cast<int>(result_.code);
  json["reason"] = result_.reason;
  json["steps"] = result_.steps;
  json["time"] = parts_.simulation->state().time;
  if (divergence_) {
    json["step"] = divergence_->step();
    json["node"] = divergence_->node() >= 0 ? Json(divergence_->node()) : Json(nullptr);
    json["term"] = divergence_->term();
  }
  json["probes"] = Json::object();
  const auto& columns = parts_.probes->columns();
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const ColumnSummary& column = parts_.probes->summaries()[i];
    // NaN, where there is no figure, is written as null.
    json["probes"][columns[i].name] = {{"unit", columns[i].unit},
                                       {"final", column.last},
                                       {"min", column.minimum},
                                       {"max", column.maximum}};
  }
  return json;
}

RunResult already_finished(const Scene& scene, const std::filesystem::path& folder) {
  RunResult result;
  result.reason = fmt::format("'{}' holds the finished run of this scene: nothing was left to do",
                              folder.string());
  result.steps = result.resumed_after = scene.steps();
  return result;
}

}  // namespace

RunResult run(const Scene& scene, std::shared_ptr<const PluginRegistry> registry,
              const RunOptions& options) {
  Resumption found;
  if (options.resume) {
    found = look_for_run(options.folder, scene);
    if (found.finished) return already_finished(scene, options.folder);
  } else {
    check_run_directory(options.folder, options.force);
  }
  return Recording(scene, std::move(registry), options, std::move(found)).execute();
}

}  // namespace deform
