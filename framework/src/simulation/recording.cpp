#include "simulation/recording.h"

#include <cmath>
#include <cstddef>
#include <utility>

#include <fmt/format.h>

#include "files/files.h"
#include "not_finite.h"
#include "simulation/memory_sections.h"
#include "simulation/run_directory.h"
#include "simulation/scene_files.h"
#include "solve/stopwatch.h"

namespace deform {
namespace {

constexpr const char* kProbesFile = "probes.csv";
/// Where a checkpoint keeps the steps between frames.
constexpr const char* kFrameInterval = "trajectory/interval";

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

}  // namespace

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
      advice_(parts_.simulation->system()),
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
    const TimesAddedTo counted(&times_);
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

template <class Action>
void Recording::apart_from_model(const Action& action) {
  const Frame frame = parts_.simulation->frame();
  apart_from_model(frame, [&] { action(frame); });
}

template <class Action>
void Recording::apart_from_model(const Frame& frame, const Action& action) {
  const TimesAddedTo nobody(nullptr);
  const double before = seconds();
  try {
    action();
  } catch (const NotFinite& e) {
    throw e.at_step(frame.step, "recording");
  }
  times_.output += seconds() - before;
}

void Recording::step_to_end() {
  auto begun = std::chrono::steady_clock::now();
  while (settle()) {
    watched(Doing::stepping, [this] { step(); });
    const auto ended = std::chrono::steady_clock::now();
    last_step_ = ended - std::exchange(begun, ended);
    advice_.look(parts_.simulation->steps(), parts_.simulation->state());
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
  stock_.times = times_;
  stock_.figures = parts_.probes->summaries();
  stock_.solver = parts_.simulation->system().solver_choice();
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
  const Stopwatch watch(&StepTimes::output, "checkpoint");
  write(make_checkpoint());
}

/// What takes long may be thrown away, and next to it this costs nothing.
void Recording::keep_checkpoint() {
  if (checkpoint_step_ == parts_.simulation->steps()) return;
  const Stopwatch watch(&StepTimes::output, "checkpoint");
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

}  // namespace deform
