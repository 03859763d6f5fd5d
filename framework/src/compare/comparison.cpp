#include "deform/compare/comparison.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "deform/error.h"
#include "deform/log.h"
#include "deform/parallel.h"
#include "deform/simulation/run.h"

#include "compare/comparison_files.h"
#include "compare/expectation.h"
#include "compare/figures.h"
#include "compare/verdict.h"
#include "files/files.h"
#include "json/json_file.h"
#include "simulation/held_folder.h"
#include "simulation/old_run.h"
#include "simulation/run_directory.h"
#include "simulation/run_parts.h"

namespace deform {
namespace {

namespace fs = std::filesystem;

/// A folder that is to be resumed in must be a comparison's, or not be there.
void check_resumable(const fs::path& folder) {
  std::error_code error;
  if (!fs::exists(folder, error) && !error) return;
  const Json manifest = read_json_object(folder / kManifestFile);
  if (!manifest.is_object() || manifest.value("kind", Json()) != "comparison")
    throw InputError(
        fmt::format("cannot resume in '{}': it is not a comparison directory", folder.string()));
}

/// What the runs' scenes say that may not be meant, each once; dropped parameters stand below the
/// table.
void warn_of_remarks(const ComparisonPlan& plan) {
  std::set<std::string> said;
  for (const PlannedRun& run : plan.runs) {
    Scene scene = run.scene;
    scene.dropped.clear();
    for (const Problem& remark : remarks_on(scene)) {
      // Without the place and the variant's name, which differ where the remark does not.
      const std::string front = run.scene.located({remark.pointer, ""}).message;
      const bool has_front = remark.message.starts_with(front);
      if (said.insert(remark.message.substr(has_front ? front.size() : 0)).second)
        log::warn(remark.message);
    }
  }
}

/// Number of the run that the others are measured against: the planned reference if it ended as
/// done, else the first run that did; one that diverged is no measure of others.
std::size_t number_of_reference(const ComparisonPlan& plan,
                                const std::vector<RunOutcome>& outcomes) {
  const auto planned = static_cast<std::size_t>(
      std::ranges::find(plan.runs, plan.reference, &PlannedRun::name) - plan.runs.begin());
  if (outcomes[planned].status == status_of(ExitCode::done)) return planned;
  const auto done = std::ranges::find(outcomes, status_of(ExitCode::done), &RunOutcome::status);
  return done == outcomes.end() ? planned : static_cast<std::size_t>(done - outcomes.begin());
}

/// Size of the surface [m]: the reference's, or that of any run that has states.
double surface_size(const std::vector<MeasuredRun>& measured, std::size_t reference) {
  if (measured[reference].recorded.trajectory)
    return measured[reference].recorded.trajectory->mesh().size;
  for (const MeasuredRun& run : measured)
    if (run.recorded.trajectory) return run.recorded.trajectory->mesh().size;
  return std::numeric_limits<double>::quiet_NaN();
}

/// What there is to read of a run. Of one that was refused there is nothing, whatever its folder
/// holds of an earlier one. One that ended for want of room on the disk may have left files
/// that are none: it has no states then, and says so.
RecordedRun read_outcome(const fs::path& folder, const RunOutcome& outcome) {
  RecordedRun nothing;
  nothing.folder = folder;
  if (outcome.status == "refused") return nothing;
  try {
    return read_run(folder);
  } catch (const InputError&) {
    if (outcome.status == "done") throw;
    return nothing;
  }
}

/// Folders of runs that none of the planned runs has: another comparison's, which is not read.
std::vector<std::string> left_over(const fs::path& folder, const ComparisonPlan& plan) {
  std::vector<std::string> names;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    std::string name = entry.path().filename().string();
    const bool is_planned =
        std::ranges::find(plan.runs, name, &PlannedRun::name) != plan.runs.end();
    if (!is_planned && !is_of_old_run(name) && entry.is_directory() && has_manifest(entry.path()))
      names.push_back(std::move(name));
  }
  std::ranges::sort(names);
  return names;
}

void say_what_is_left_over(const fs::path& folder, const ComparisonPlan& plan) {
  const std::vector<std::string> names = left_over(folder, plan);
  if (names.empty()) return;
  log::warn(
      fmt::format("'{}' also holds runs that are not of this comparison, and no part of it: {}",
                  folder.string(), fmt::join(names, ", ")));
}

std::vector<MeasuredRun> measure(const ComparisonPlan& plan, std::size_t reference,
                                 const RunnerOptions& options,
                                 const std::vector<RunOutcome>& outcomes) {
  const fs::path& folder = options.folder;
  std::vector<MeasuredRun> measured(plan.runs.size());
  parallel_blocks(static_cast<Index>(measured.size()), 1, [&](Index number, Index /*one*/) {
    const auto i = static_cast<std::size_t>(number);
    if (options.interrupted != nullptr && options.interrupted->load())
      throw Error(ExitCode::interrupted, "interrupted; --resume goes on from there");
    measured[i].recorded = read_outcome(folder / plan.runs[i].name, outcomes[i]);
    if (i == reference) return;
    // Each has the reference to itself: a trajectory is read by one thread at a time.
    const RecordedRun other = read_outcome(folder / plan.runs[reference].name, outcomes[reference]);
    measured[i].differences = differences(measured[i].recorded, other);
  });
  return measured;
}

Comparison conclude(const ComparisonOptions& options, const ComparisonPlan& plan,
                    std::size_t reference, std::vector<RunOutcome> outcomes,
                    const std::vector<MeasuredRun>& measured) {
  Comparison comparison;
  comparison.reference = plan.runs[reference].name;
  comparison.planned_reference = plan.reference;
  comparison.tolerance = options.request.tolerance > 0 ? options.request.tolerance
                                                       : plan.runs.front().scene.tolerance *
                                                             surface_size(measured, reference);
  std::map<std::string_view, std::string> first_of;  // name of the first run of a scene
  for (std::size_t i = 0; i < plan.runs.size(); ++i) {
    RunComparison run;
    run.name = plan.runs[i].name;
    const auto [first, is_new] = first_of.try_emplace(plan.runs[i].scene.completed, run.name);
    if (!is_new) run.same_as = first->second;
    run.outcome = std::move(outcomes[i]);
    run.dropped = plan.runs[i].scene.dropped;
    run.is_reference = i == reference;
    const RunDifferences& different = measured[i].differences;
    if (!run.is_reference) run.impossible = different.impossible;
    run.compared = different.rows.size();
    run.recorded = different.recorded;
    if (const Difference* at = different.parting(comparison.tolerance))
      run.parting = Parting{at->moment.step, at->moment.time, at->where, at->node, at->max};
    run.figures = figures_of(measured[i].recorded, different, run.parting, run.outcome);
    run.ms_per_step = ms_per_step(measured[i].recorded);
    comparison.runs.push_back(std::move(run));
  }
  return comparison;
}

}  // namespace

double RunComparison::figure(const std::string& wanted) const {
  const auto found = std::ranges::find(figures, wanted, &Figure::name);
  return found == figures.end() ? std::numeric_limits<double>::quiet_NaN() : found->value;
}

std::vector<Figure> probe_columns(const Comparison& comparison) {
  std::vector<Figure> columns;
  for (const RunComparison& run : comparison.runs) {
    for (const Figure& figure : run.figures) {
      // Of the figures only those of probes have a smallest one beside them.
      const bool is_probe =
          std::ranges::find(run.figures, figure.name + ".min", &Figure::name) != run.figures.end();
      const bool is_new = std::ranges::find(columns, figure.name, &Figure::name) == columns.end();
      if (is_probe && is_new)
        columns.push_back({figure.name, figure.unit, std::numeric_limits<double>::quiet_NaN()});
    }
  }
  return columns;
}

namespace {

/// No run of a comparison that replaces another one took a step.
Error refusal_to_replace(const ComparisonPlan& plan, const RunOutcome& first) {
  const ExitCode code = first.status == status_of(ExitCode::diverged) ? ExitCode::diverged
                        : first.status == status_of(ExitCode::plugin_failed)
                            ? ExitCode::plugin_failed
                            : ExitCode::internal_error;
  return {code, fmt::format("no run took a step ({}: {} {}); the comparison that was there stays",
                            plan.runs.front().name, first.status, first.reason)};
}

/// Runs what is planned. Until the first step of any run an older comparison is there, and comes
/// back where that is never taken.
std::vector<RunOutcome> execute(const ComparisonOptions& options, const ComparisonPlan& plan,
                                const PluginRegistry& registry, HeldFolder& held) {
  RunnerOptions runner = options.runner;
  runner.first_step = [&held] { held.drop_old(); };
  std::vector<RunOutcome> outcomes;
  try {
    outcomes = execute_runs(plan.runs, registry, runner);
  } catch (...) {
    (void)held.give_old_back();
    throw;
  }
  if (held.give_old_back()) throw refusal_to_replace(plan, outcomes.front());
  return outcomes;
}

/// What comes before the first run; an older comparison is there until then.
void begin(const ComparisonOptions& options, const ComparisonPlan& plan, HeldFolder& held) {
  const fs::path& folder = options.runner.folder;
  try {
    if (options.runner.resume)
      held.take();
    else
      held.begin_anew();
    // First: from here on the folder is known as a comparison's.
    write_atomically(folder / kManifestFile, manifest_json(options, plan, "running"));
  } catch (...) {
    (void)held.give_old_back();
    throw;
  }
  say_what_is_left_over(folder, plan);
}

}  // namespace

Comparison compare(const ComparisonOptions& options,
                   const std::shared_ptr<const PluginRegistry>& registry) {
  const fs::path& folder = options.runner.folder;
  HeldFolder held(folder, options.runner.resume ? FolderUse::resumed
                          : options.force       ? FolderUse::replaced
                                                : FolderUse::made);
  if (options.runner.resume) check_resumable(folder);
  const ComparisonPlan plan =
      plan_comparison(options.request, registry, options.runner.interrupted);
  std::vector<std::string> claims;
  if (!options.expectation.empty()) claims = read_claims(options.expectation, plan);

  begin(options, plan, held);
  warn_of_remarks(plan);
  for (const PlannedRun& run : plan.runs)
    for (const std::string& pointer : run.scene.dropped)
      log::info(fmt::format("{}: {} is dropped: the plugin put in has no such parameter", run.name,
                            pointer));

  std::vector<RunOutcome> outcomes = execute(options, plan, *registry, held);
  const std::size_t reference = number_of_reference(plan, outcomes);
  const std::vector<MeasuredRun> measured = measure(plan, reference, options.runner, outcomes);
  Comparison comparison = conclude(options, plan, reference, std::move(outcomes), measured);
  comparison.sentences = sentences_of(comparison);
  comparison.claims = check_claims(claims, comparison);

  write_atomically(folder / "comparison.csv", comparison_csv(comparison, measured));
  write_atomically(folder / "cost.csv", cost_csv(comparison, measured));
  write_atomically(folder / "summary.json", summary_json(comparison, plan, folder));
  write_atomically(folder / kManifestFile, manifest_json(options, plan, "done"));
  return comparison;
}

}  // namespace deform
