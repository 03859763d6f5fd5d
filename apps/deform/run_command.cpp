#include "run_command.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <unistd.h>

#include <fmt/format.h>

#include "deform/simulation/run.h"

#include "commit.h"
#include "interrupt.h"
#include "report_command.h"
#include "terminal.h"

namespace deform::app {
namespace {

std::filesystem::path default_folder(const RunCommand& command) {
  std::string name = command.scene.stem().string();
  if (command.variant != "base") name += "-" + command.variant;
  return std::filesystem::path("runs") / name;
}

/// Milliseconds a step, by part; what the parts do not account for is "other".
void print_times(const RunResult& result) {
  const long steps = result.steps - result.resumed_after;
  if (steps == 0) return;
  const StepTimes& t = result.times;
  const double known = t.geometry + t.assembly + t.factorisation + t.solve + t.output;
  const auto per_step = [steps](double seconds) {
    return 1e3 * seconds / static_cast<double>(steps);
  };
  say("  ms/step       {:.3f}: geometry {:.3f}, assembly {:.3f}, factorisation {:.3f}, "
      "solve {:.3f}, output {:.3f}, other {:.3f}\n",
      per_step(result.stepping_seconds), per_step(t.geometry), per_step(t.assembly),
      per_step(t.factorisation), per_step(t.solve), per_step(t.output),
      per_step(std::max(0.0, result.stepping_seconds - known)));
}

void print_figures(const RunResult& result) {
  std::size_t width = 0;
  for (const auto& [name, figure] : result.figures) width = std::max(width, name.size());
  for (const auto& [name, figure] : result.figures) {
    say("  {:<{}}  {}\n", name, width, std::isnan(figure) ? "-" : fmt::format("{: .6g}", figure));
  }
}

void print_summary(const RunResult& result, const std::filesystem::path& folder) {
  say("{}\n", folder.string());
  if (result.code != ExitCode::done) say("  ended         {}\n", status_of(result.code));
  say("  steps         {}{}\n", result.steps,
      result.resumed_after > 0 ? fmt::format(" ({} of them before)", result.resumed_after) : "");
  say("  wall time     {:.2f} s\n", result.wall_seconds);
  print_times(result);
  print_figures(result);
}

}  // namespace

int run_scene(const RunCommand& command, const std::shared_ptr<const PluginRegistry>& registry,
              ProgressBar& bar) {
  const Scene scene = read_scene(command.scene, *registry, command.replacements, command.variant);
  RunOptions options;
  options.folder = command.folder.empty() ? default_folder(command) : command.folder;
  options.force = command.force;
  options.resume = command.resume;
  options.profile = command.profile;
  options.interrupted = &watch_interrupts();
  options.command_line = command.command_line;
  options.commit = commit();
  options.progress = [&bar](long done, long total) { bar.update(done, total); };
  if (command.part_of_comparison) options.progress = ProgressLines();
  options.abandon = [&bar](const RunResult& result) {
    bar.end();
    complain("{}", result.reason);
    (void)std::fflush(stdout);
    ::_exit(static_cast<int>(result.code));
  };

  const bool quiet = command.quiet || command.part_of_comparison;
  if (!quiet) bar.begin();
  RunResult result;
  try {
    result = run(scene, registry, options);
  } catch (...) {
    bar.end();
    throw;
  }
  bar.end();
  if (!result.reason.empty()) complain("{}", result.reason);
  if (!quiet) {
    print_summary(result, options.folder);
    put_lines(result.profile);
  }
  // A comparison has a report of its own, which shows them all.
  if (!scene.frames_written || command.part_of_comparison || result.kept_old_run)
    return static_cast<int>(result.code);
  const AddedReport report = add_report(options.folder);
  if (!quiet) say("  report        {}\n", report.told);
  return static_cast<int>(result.code == ExitCode::done ? report.code : result.code);
}

}  // namespace deform::app
