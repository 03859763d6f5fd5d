#include "deform/simulation/run.h"

#include <atomic>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <future>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "deform/log.h"

#include "files/files.h"
#include "files/sha256.h"
#include "json/json.h"
#include "not_finite.h"
#include "plugin/process_end.h"
#include "profile/profile.h"
#include "record/trajectory_writer.h"
#include "simulation/balance_guards.h"
#include "simulation/checkpoint.h"
#include "simulation/held_folder.h"
#include "simulation/manifest.h"
#include "simulation/memory_sections.h"
#include "simulation/resumption.h"
#include "simulation/run_directory.h"
#include "simulation/run_log.h"
#include "simulation/run_parts.h"
#include "simulation/scene_files.h"
#include "simulation/step_watch.h"
#include "solve/stopwatch.h"

namespace deform {
namespace {

constexpr const char *kProbesFile = "probes.csv", *kSummaryFile = "summary.json";
/// Where a checkpoint keeps the steps between frames.
constexpr const char* kFrameInterval = "trajectory/interval";
/// Of who gives up, for what others are about.
constexpr std::chrono::milliseconds kLongestWait{100};
/// Of what has not been done yet: it may take long.
constexpr auto kUnknown = std::chrono::steady_clock::duration::max();
constexpr const char* kNothingWritten = "interrupted before the first step; nothing was written";
/// What a profiled run leaves in its directory.
constexpr const char *kProfileTable = "profile.txt", *kProfileTrace = "trace.json";

/// Bytes of a file that a checkpoint goes on from.
std::size_t bytes_of(const Checkpoint& checkpoint, const char* name) {
  const WrittenFile* file = checkpoint.file(name);
  if (file == nullptr || file->bytes == 0) throw InputError(fmt::format("it knows no {}", name));
  return file->bytes;
}

/// A run that is prolonged keeps the interval that it began with: about a hundred frames of a
/// longer run would lie farther apart.
long frame_interval_of(const Checkpoint& checkpoint) {
  constexpr double kMost = 0x1p53;
  const double interval = checkpoint.memory.get(kFrameInterval, 1).front();
  if (!(interval >= 1 && interval < kMost && interval == std::floor(interval)))
    throw InputError("its steps between frames are no number of steps");
  return static_cast<long>(interval);
}

/// One run from its first to its last file.
class Recording {
 public:
  /// Throws InputError when the scene or the checkpoint cannot be used; writes nothing.
  Recording(const Scene& scene, std::shared_ptr<const PluginRegistry> registry,
            const RunOptions& options, Manifest manifest, Resumption found, HeldFolder held,
            StepWatch& watch);
  RunResult execute();

 private:
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
  CheckpointSchedule schedule_;
  BalanceGuards guards_;
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

Recording::Recording(const Scene& scene, std::shared_ptr<const PluginRegistry> registry,
                     const RunOptions& options, Manifest manifest, Resumption found,
                     HeldFolder held, StepWatch& watch)
    : scene_(scene),
      options_(options),
      folder_(std::filesystem::absolute(options.folder)),
      held_(std::move(held)),
      manifest_(std::move(manifest)),
      found_(std::move(found)),
      parts_(make_run_parts(scene, registry)),
      schedule_(scene),
      guards_(parts_.simulation->system(), parts_.simulation->integrator()),
      watch_(watch),
      frame_interval_(scene.frame_interval()) {
  parts_.simulation->stop_when(&watch_.stop());
  require_unchanged_files();
  context_.emplace(make_run_context(parts_, folder_));
  if (found_.checkpoint) context_->resumed_at = found_.checkpoint->step;
  begin_probes(parts_, *context_);  // may still reject the scene, so comes before the folder
  remarks_ = remarks_on(parts_);
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
    if (scene_.frames_written) {
      (void)bytes_of(checkpoint, kTrajectoryFile);
      if (scene_.frames_every == 0) frame_interval_ = frame_interval_of(checkpoint);
    }
  } catch (const InputError& e) {
    throw InputError(
        fmt::format("cannot resume from {}: {}", checkpoint_file(folder_).string(), e.what()));
  }
  checkpoint_step_ = result_.resumed_after = checkpoint.step;
}

/// What the manifest says of the files must hold for what the parts were made of.
void Recording::require_unchanged_files() const {
  const std::vector<HashedFile> now = hashed_files(scene_);
  for (std::size_t i = 0; i < now.size(); ++i) {
    if (now[i].sha256 != manifest_.files()[i].sha256)
      throw InputError({{now[i].pointer, fmt::format("{} changed while it was read: run it again",
                                                     now[i].path.string())}});
  }
}

/// Throws where nothing can be written; an old run is then still there.
void Recording::begin_folder() {
  try {
    if (found_.checkpoint)
      remove_half_written(folder_);
    else
      held_.begin_anew(!found_.planned);
    manifest_.write(folder_);  // first: from here on the folder is known as one of ours
    log_.emplace(folder_ / "log.txt", found_.checkpoint.has_value());
  } catch (...) {
    (void)held_.give_old_back();
    throw;
  }
}

RunResult Recording::execute() {
  begin_folder();
  log::info(fmt::format("run '{}': {} steps of {} s", scene_.title, scene_.steps(), scene_.step));
  if (found_.checkpoint) {
    log::info(fmt::format("resumed after step {}", checkpoint_step_.load()));
    manifest_.resume(checkpoint_step_);
    manifest_.write(folder_);
    if (frame_interval_ != scene_.frame_interval())
      log::info(fmt::format("frames go on every {} steps, as the run began", frame_interval_));
  } else if (options_.resume && !found_.planned) {
    log::warn(fmt::format("there is no checkpoint in {}: the run starts anew", folder_.string()));
  }
  for (const Problem& remark : remarks_) log::warn(remark.message);
  const auto [before, after] = manifest_.if_process_ends();
  last_note_.emplace(folder_ / kManifestFile, before, after);
  try {
    write_atomically(folder_ / "scene.json", scene_text(scene_, folder_));
    for (const std::string& note : parts_.simulation->system().terms().notes()) log::info(note);
    watched(Doing::beginning, [this] { start(); });
    const Profile::Active active(profile_ ? &*profile_ : nullptr);
    const Span span("run");
    parts_.simulation->system().times() = {};
    stepping_since_ = std::chrono::steady_clock::now();
    step_to_end();
  } catch (const Diverged& e) {
    divergence_ = e;
    end_with(e);
  } catch (const Error& e) {
    if (e.code() == ExitCode::interrupted)
      end_within(result_);
    else
      end_with(e);
  } catch (const std::exception& e) {
    end_with(ExitCode::internal_error, e.what());
  }
  finish();
  keep_old_run(result_);
  return std::move(result_);
}

/// Where the new run ended before its first step, and there is an old one.
void Recording::keep_old_run(RunResult& result) {
  if (!held_.give_old_back()) return;
  result.kept_old_run = true;
  result.reason += fmt::format("; the run that was in '{}' stays", options_.folder.string());
}

void Recording::start() {
  parts_.probes->open(folder_ / kProbesFile,
                      found_.checkpoint ? bytes_of(*found_.checkpoint, kProbesFile) : 0);
  if (scene_.frames_written) open_trajectory();
  parts_.outputs->begin(*context_);
  if (found_.checkpoint) parts_.outputs->load(found_.checkpoint->memory);
}

void Recording::open_trajectory() {
  const std::size_t keep = found_.checkpoint ? bytes_of(*found_.checkpoint, kTrajectoryFile) : 0;
  Simulation& simulation = *parts_.simulation;
  trajectory_.emplace(folder_ / kTrajectoryFile, simulation.system(), simulation.size(), keep);
}

void Recording::step_to_end() {
  auto begun = std::chrono::steady_clock::now();
  while (settle()) {
    watched(Doing::stepping, [this] { step(); });
    const auto ended = std::chrono::steady_clock::now();
    last_step_ = ended - std::exchange(begun, ended);
    if (held_.has_old()) watched(Doing::clearing, [this] { held_.drop_old(); });
    if (profile_) profile_->end_step();
    if (options_.progress) options_.progress(parts_.simulation->steps(), scene_.steps());
  }
  if (interrupted()) return;
  watched(Doing::recording,
          [this] { apart_from_model([this](const Frame& frame) { guards_.finish(frame); }); });
}

void Recording::step() {
  const bool watches = guards_.watches(parts_.simulation->steps());
  if (parts_.probes->none() && !watches) return parts_.simulation->step();
  if (watches) apart_from_model([this](const Frame& frame) { guards_.begin(frame); });
  parts_.simulation->step([&](const Frame& at_break) {
    apart_from_model(at_break, [&] {
      if (watches) guards_.at_break(at_break);
      parts_.probes->follow_break(at_break);
    });
  });
  apart_from_model([&](const Frame& frame) {
    if (watches) guards_.end(frame);
    parts_.probes->follow(frame);
  });
}

void Recording::take_stock(Doing doing) {
  const Simulation& simulation = *parts_.simulation;
  stock_.doing = doing;
  stock_.result = result_;
  stock_.has_old_run = held_.has_old() && doing != Doing::clearing;
  const bool is_used = doing == Doing::checkpointing || doing == Doing::ending;
  stock_.fallback = before_step_ && !is_used ? &*before_step_ : nullptr;
  if (is_thrown_away_) return;  // what came since does not count
  stock_.steps = simulation.steps();
  stock_.time = simulation.state().time;
  stock_.times = parts_.simulation->system().times();
  stock_.figures = parts_.probes->summaries();
  stock_.solver = parts_.simulation->system().solver_choice();
}

template <class Action>
void Recording::watched(Doing doing, const Action& action) {
  take_stock(doing);
  const std::function<void()> give_up = [this] { this->give_up(); };
  const StepWatch::Span span(watch_, give_up);
  action();
}

void Recording::give_up() noexcept {
  if (!options_.abandon) return;
  RunResult result;
  result.code = ExitCode::interrupted;
  // Not let go any more: what the main thread is writing gets into the folder now or never.
  const std::unique_lock no_more(checkpointing_, kLongestWait);
  try {
    is_given_up_ = true;
    result = stock_.result;
    result.stepping_seconds = stepping_seconds();
    end_within(result);
    conclude(result, leave_files(result));
    if (stock_.has_old_run) and_also(result, [&] { keep_old_run(result); });
  } catch (...) {  // no room for a word of it, and the process has to end all the same
  }
  options_.abandon(result);
}

void Recording::end_within(RunResult& result) {
  const bool is_first = result.code == ExitCode::done;
  is_thrown_away_ = true;
  if (stock_.fallback != nullptr) and_also(result, [this] { write(*stock_.fallback); });
  if (!is_first) return;  // the first reason is the one that counts
  const long done = stock_.steps, total = scene_.steps(), kept = checkpoint_step_;
  const std::string where =
      stock_.doing == Doing::stepping
          ? fmt::format("within step {} of {}, which is thrown away", done + 1, total)
          : fmt::format("after {} of {} steps, before all was recorded", done, total);
  end(result, ExitCode::interrupted,
      fmt::format("interrupted {}; {}", where,
                  kept >= 0 ? fmt::format("--resume goes on after step {}", kept)
                            : "there is no checkpoint yet"));
}

bool Recording::settle() {
  const long step = parts_.simulation->steps(), total = scene_.steps();
  const bool last = step == total;
  const bool stop = !last && interrupted();
  // Before the recording: see Checkpoint. The last one serves who prolongs the run.
  before_step_.reset();
  const bool saves = last || stop || schedule_.due(step),
             records = last || stop || is_recorded(step);
  const bool may_be_thrown_away =
      last_step_ > StepWatch::kPatience || (records && last_recording_ > StepWatch::kPatience);
  if (saves || may_be_thrown_away)
    watched(Doing::checkpointing, [&] {
      if (saves) save_checkpoint();
      if (may_be_thrown_away) keep_checkpoint();
    });
  // A row too many goes when the run is resumed; a frame's files would stay.
  if (records) {
    const auto begun = std::chrono::steady_clock::now();
    watched(Doing::recording, [&] { record(last || stop, last); });
    last_recording_ = std::chrono::steady_clock::now() - begun;
    if (last_step_ <= StepWatch::kPatience) before_step_.reset();  // a step is taken again
  }
  if (stop) {
    end_with(
        ExitCode::interrupted,
        fmt::format("interrupted after {} of {} steps; --resume goes on from there", step, total));
  }
  return !last && !stop;
}

void Recording::save_checkpoint() {
  if (checkpoint_step_ == parts_.simulation->steps()) return;
  const Stopwatch watch(parts_.simulation->system().times().output, "checkpoint");
  write(make_checkpoint());
}

/// What takes long may be thrown away, and next to it this costs nothing.
void Recording::keep_checkpoint() {
  if (checkpoint_step_ == parts_.simulation->steps()) return;
  const Stopwatch watch(parts_.simulation->system().times().output, "checkpoint");
  before_step_ = make_checkpoint();
}

Checkpoint Recording::make_checkpoint() {
  Simulation& simulation = *parts_.simulation;
  writing_.drain();  // files of earlier steps are there before what relies on them
  Checkpoint checkpoint;
  checkpoint.scene = identity_of(scene_.completed, manifest_.files());
  checkpoint.step = simulation.steps();
  checkpoint.files = parts_.outputs->files(folder_);
  checkpoint.files.push_back(parts_.probes->sync());  // on disk before what relies on it
  save_section(simulation, "simulation", checkpoint.memory);
  parts_.probes->save(checkpoint.memory);
  parts_.outputs->save(checkpoint.memory);
  if (trajectory_) {
    checkpoint.files.push_back(trajectory_->sync());
    checkpoint.memory.put(kFrameInterval, {static_cast<double>(frame_interval_)});
  }
  return checkpoint;
}

void Recording::write(const Checkpoint& checkpoint) {
  const std::lock_guard lock(checkpointing_);
  write_checkpoint(folder_, checkpoint);
  checkpoint_step_ = checkpoint.step;
  schedule_.restart();
}

template <class Action>
void Recording::apart_from_model(const Action& action) {
  const Frame frame = parts_.simulation->frame();
  apart_from_model(frame, [&] { action(frame); });
}

template <class Action>
void Recording::apart_from_model(const Frame& frame, const Action& action) {
  const StepTimes model = frame.system.times();
  const double before = seconds();
  try {
    action();
  } catch (const NotFinite& e) {
    throw e.at_step(frame.step, "recording");
  }
  frame.system.times() = model;
  frame.system.times().output += seconds() - before;
}

bool Recording::frame_due(long step) const {
  return trajectory_.has_value() && step % frame_interval_ == 0;
}

bool Recording::is_recorded(long step) const {
  return step == 0 || parts_.probes->due(step) || parts_.outputs->due(step) || frame_due(step);
}

void Recording::record(bool all_probes, bool all_outputs) {
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

void Recording::end(RunResult& result, ExitCode code, const std::string& reason) {
  result.code = code;
  result.reason = reason;
  log::info(fmt::format("the run ends: {}", reason));
}

void Recording::end_with(const Error& error) {
  const bool names_step = error.code() == ExitCode::diverged;
  end_with(error.code(), names_step ? error.what()
                                    : fmt::format("{} (after step {})", error.what(),
                                                  parts_.simulation->steps()));
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

void Recording::finish() {
  std::vector<WrittenFile> files;
  watched(Doing::ending, [&] {
    if (divergence_ && divergence_->step() > parts_.simulation->steps())
      and_also([this] { record(true, true); });  // the last good state
    result_.stepping_seconds = stepping_seconds();
    and_also([this] { writing_.drain(); });
    and_also([this] { parts_.outputs->end(); });
    if (profile_) and_also([this] { write_profile(); });
    files = close_files(result_);
  });
  take_stock(Doing::ending);
  conclude(result_, files);
}

std::vector<WrittenFile> Recording::leave_files(RunResult& result) {
  const bool is_written = writing_.drain_within(kLongestWait);
  // The main thread is at work with them otherwise.
  if (stock_.doing != Doing::stepping) return {};
  if (is_written) {
    // What hangs is left behind, with the process.
    auto ending = std::make_shared<std::promise<void>>();
    std::future<void> ended = ending->get_future();
    std::thread([this, ending] {
      try {
        parts_.outputs->end();
        ending->set_value();
      } catch (...) {
        ending->set_exception(std::current_exception());
      }
    }).detach();
    if (ended.wait_for(kLongestWait) == std::future_status::ready)
      and_also(result, [&] { ended.get(); });
  }
  return close_files(result);
}

void Recording::conclude(RunResult& result, const std::vector<WrittenFile>& files) {
  for (const WrittenFile& file : files) manifest_.add_result(file);
  result.steps = stock_.steps;
  result.times = stock_.times;
  result.times.steps = stock_.steps - result.resumed_after;
  const auto& columns = parts_.probes->columns();
  for (std::size_t i = 0; i < columns.size(); ++i) {
    result.figures.emplace_back(header_of(columns[i]), stock_.figures[i].last);
  }
  and_also(result, [&] {
    const std::string text =
        summary(result).dump(2, ' ', false, Json::error_handler_t::replace) + '\n';
    write_atomically(folder_ / kSummaryFile, text);
    manifest_.add_result({kSummaryFile, text.size(), sha256_of(text)});
  });
  result.wall_seconds = seconds();
  log::info(fmt::format("{} after {} steps and {:.3f} s", status_of(result.code), result.steps,
                        result.wall_seconds));
  last_note_.reset();
  if (!is_given_up_) and_also(result, [this] { log_->close(); });
  manifest_.finish(result, stock_.solver);
  and_also(result, [this] { manifest_.write(folder_); });
}

std::vector<WrittenFile> Recording::close_files(RunResult& result) {
  std::vector<WrittenFile> files;
  and_also(result, [&] {
    if (const auto table = parts_.probes->close()) files.push_back(*table);
  });
  and_also(result, [&] {
    if (trajectory_) files.push_back(trajectory_->close());
  });
  return files;
}

void Recording::write_profile() {
  result_.profile = profile_->table();
  write_atomically(folder_ / kProfileTable, result_.profile);
  write_atomically(folder_ / kProfileTrace, profile_->trace());
}

Json Recording::summary(const RunResult& result) const {
  Json json;
  json["status"] = status_of(result.code);
  json["exit_code"] = static_cast<int>(result.code);
  json["reason"] = result.reason;
  json["steps"] = result.steps;
  json["time"] = stock_.time;
  if (divergence_) {
    json["step"] = divergence_->step();
    json["node"] = divergence_->node() >= 0 ? Json(divergence_->node()) : Json(nullptr);
    json["term"] = divergence_->term();
  }
  json["probes"] = Json::object();
  const auto& columns = parts_.probes->columns();
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const ColumnSummary& column = stock_.figures[i];
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
  HeldFolder held(options.folder, options.resume  ? FolderUse::resumed
                                  : options.force ? FolderUse::replaced
                                                  : FolderUse::made);
  Manifest manifest(scene, *registry, options);
  Resumption found;
  if (options.resume) {
    found = look_for_run(options.folder, scene, manifest);
    if (found.finished) return already_finished(scene, options.folder);
  }
  StepWatch watch(options.interrupted);
  std::optional<Recording> recording;
  {
    const std::function<void()> give_up = [&options] {
      RunResult result;
      result.code = ExitCode::interrupted;
      result.reason = kNothingWritten;
      if (options.abandon) options.abandon(result);
    };
    const StepWatch::Span watched(watch, give_up);
    recording.emplace(scene, std::move(registry), options, std::move(manifest), std::move(found),
                      std::move(held), watch);
  }
  if (options.interrupted != nullptr && options.interrupted->load())
    throw Error(ExitCode::interrupted, kNothingWritten);
  return recording->execute();
}

}  // namespace deform
