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

#include "scene/json.h"
#include "simulation/files.h"
#include "simulation/manifest.h"
#include "simulation/part_maker.h"
#include "simulation/recorders.h"
#include "simulation/run_directory.h"
#include "simulation/run_log.h"
#include "solve/stopwatch.h"

namespace deform {
namespace {

/// What a run is made of; made before anything is written.
struct Parts {
  std::unique_ptr<Simulation> simulation;
  std::optional<ProbeRecorder> probes;
  std::optional<OutputRecorder> outputs;
};

/// Throws InputError with the problems of the model, the probes and the outputs together.
Parts make_parts(const Scene& scene, const std::shared_ptr<const PluginRegistry>& registry) {
  std::shared_ptr<const Surface> own;  // where there is no simulation to take it from
  Parts parts;
  PartMaker maker(scene, registry);
  const Surface* surface = nullptr;
  try {
    parts.simulation = std::make_unique<Simulation>(scene, registry);
    surface = &parts.simulation->system().surface();
  } catch (const InputError& e) {
    // Look at probes and outputs all the same, if there is a surface for them to look at.
    PartMaker again(scene, registry);
    if (auto made = again.make<Surface>(scene.surface, again.setup())) own = made->object;
    surface = own.get();
    maker.add(e.problems());
  }
  if (surface != nullptr) {
    const Setup setup = maker.setup(*surface, surface->rest());
    parts.probes.emplace(scene.probes, maker, setup);
    parts.outputs.emplace(scene.outputs, maker, setup);
  }
  maker.throw_problems();
  return parts;
}

/// One run from its first to its last file.
class Recording {
 public:
  Recording(const Scene& scene, std::shared_ptr<const PluginRegistry> registry,
            const RunOptions& options);
  RunResult execute();

 private:
  void start();
  void step_to_end();
  void record(bool last);
  /// Calls action(frame); what it makes the System compute counts as output, not as the model's
  /// time.
  template <class Action>
  void apart_from_model(const Action& action);
  void end_with(ExitCode code, const std::string& reason);
  void end_with(const Error& error);
  void finish();
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
  Parts parts_;
  std::optional<RunContext> context_;
  Manifest manifest_;
  std::optional<Diverged> divergence_;
  RunResult result_;
};

Recording::Recording(const Scene& scene, std::shared_ptr<const PluginRegistry> registry,
                     const RunOptions& options)
    : scene_(scene),
      options_(options),
      folder_(std::filesystem::absolute(options.folder)),
      parts_(make_parts(scene, registry)),
      manifest_(scene, *registry, options) {
  Simulation& simulation = *parts_.simulation;
  context_.emplace(RunContext{folder_, scene.title, simulation.system(),
                              [&simulation] { return simulation.mirrored(); }});
  parts_.probes->begin(*context_);  // may still reject the scene, so comes before the folder
}

RunResult Recording::execute() {
  make_run_directory(folder_);
  manifest_.write(folder_);  // first: from here on the folder is known as one of ours
  const RunLog log(folder_ / "log.txt");
  write_atomically(folder_ / "scene.json", scene_.completed);
  log::info(fmt::format("run '{}': {} steps of {} s", scene_.title, scene_.steps(), scene_.step));
  try {
    start();
    const Stopwatch watch(result_.stepping_seconds);
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
  parts_.probes->open(folder_ / "probes.csv");
  parts_.outputs->begin(*context_);
  record(scene_.steps() == 0);
}

void Recording::step_to_end() {
  const long total = scene_.steps();
  Simulation& simulation = *parts_.simulation;
  while (simulation.steps() < total) {
    if (interrupted()) {
      // The place for a checkpoint: the state is whole here, and finish() closes all files.
      end_with(ExitCode::interrupted,
               fmt::format("interrupted after {} of {} steps", simulation.steps(), total));
      return;
    }
    simulation.step();
    if (!parts_.probes->none()) {
      apart_from_model([this](const Frame& frame) { parts_.probes->follow(frame); });
    }
    record(simulation.steps() == total);
    if (options_.progress) options_.progress(simulation.steps(), total);
  }
}

template <class Action>
void Recording::apart_from_model(const Action& action) {
  const Frame frame = parts_.simulation->frame();
  const StepTimes model = frame.system.times();
  const double before = seconds();
  action(frame);
  frame.system.times() = model;
  frame.system.times().output += seconds() - before;
}

void Recording::record(bool last) {
  const long step = parts_.simulation->steps();
  if (!last && step != 0 && !parts_.probes->due(step) && !parts_.outputs->due(step)) return;
  apart_from_model([this, last](const Frame& frame) {
    parts_.probes->record(frame, last);
    parts_.outputs->record(frame, last);
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
  if (result_.code == ExitCode::diverged || result_.code == ExitCode::interrupted) {
    and_also([this] { record(true); });  // the last good state
  }
  and_also([this] { parts_.outputs->end(); });

  Simulation& simulation = *parts_.simulation;
  result_.steps = simulation.steps();
  result_.times = simulation.system().times();
  result_.times.steps = simulation.steps();
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

}  // namespace

RunResult run(const Scene& scene, std::shared_ptr<const PluginRegistry> registry,
              const RunOptions& options) {
  check_run_directory(options.folder, options.force);
  return Recording(scene, std::move(registry), options).execute();
}

}  // namespace deform
