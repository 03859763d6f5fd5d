#include "compare_command.h"

#include <algorithm>
#include <cstdio>
#include <map>
#include <string>
#include <thread>

#include <fmt/format.h>

#include "comparison_table.h"
#include "interrupt.h"
#include "report_command.h"
#include "table.h"
#include "terminal.h"

namespace deform::app {
namespace {

/// What a paper's or a chat's column takes.
constexpr std::size_t kTableWidth = 100;

std::filesystem::path default_folder(const std::filesystem::path& scene) {
  return std::filesystem::path("runs") / (scene.stem().string() + "-comparison");
}

std::vector<std::string> arguments_of_runs(
    const CompareCommand& command, const std::vector<std::filesystem::path>& plugin_folders) {
  const int jobs = std::max(command.options.runner.jobs, 1);
  const auto all = static_cast<int>(std::max(std::thread::hardware_concurrency(), 1U));
  const int threads = command.threads > 0 ? command.threads : std::max(all / jobs, 1);
  std::vector<std::string> arguments{"--threads", std::to_string(threads)};
  for (const std::filesystem::path& folder : plugin_folders) {
    arguments.emplace_back("--plugin-path");
    arguments.push_back(std::filesystem::absolute(folder).string());
  }
  return arguments;
}

/// Each parameter that a varied plugin does not have, with the runs that go without it.
void print_dropped(const Comparison& comparison) {
  constexpr std::size_t kMostNamed = 4;
  std::map<std::string, std::vector<std::string>> runs_without;
  for (const RunComparison& run : comparison.runs)
    for (const std::string& pointer : run.dropped) runs_without[pointer].push_back(run.name);
  for (const auto& [pointer, runs] : runs_without) {
    const std::string who = runs.size() <= kMostNamed ? fmt::format("{}", fmt::join(runs, ", "))
                                                      : fmt::format("{} runs", runs.size());
    print_wrapped(
        "  ", fmt::format("Dropped, as the plugin has no such parameter: {} ({}).", pointer, who),
        kTableWidth);
  }
}

void print_comparison(const Comparison& comparison, const std::filesystem::path& folder) {
  say("{}\n", folder.string());
  print_table(comparison_table(comparison, kTableWidth));
  say("\n");
  for (const std::string& sentence : comparison.sentences)
    print_wrapped("  ", sentence, kTableWidth);
  print_dropped(comparison);
}

/// Returns whether all hold. Those that do not are errors, those that do are part of the summary.
bool print_claims(const std::vector<Claim>& claims, bool quiet) {
  bool all = true;
  for (const Claim& claim : claims) {
    all = all && claim.holds;
    const std::string line = fmt::format("{}: {} ({})", claim.holds ? "holds" : "does not hold",
                                         claim.text, claim.explanation);
    if (!claim.holds)
      complain("{}", line);
    else if (!quiet)
      print_wrapped("  ", line, kTableWidth);
  }
  return all;
}

/// Whether there are runs that came to no result for want of room on the disk, say: what is
/// measured then is not what was asked for.
bool print_failures(const Comparison& comparison) {
  bool any = false;
  for (const RunComparison& run : comparison.runs) {
    if (!run.outcome.is_failure) continue;
    any = true;
    complain("{}: {}", run.name, run.outcome.reason);
  }
  return any;
}

}  // namespace

int compare_scene(CompareCommand command, const std::vector<std::filesystem::path>& plugin_folders,
                  const std::shared_ptr<const PluginRegistry>& registry, ProgressBar& bar) {
  RunnerOptions& runner = command.options.runner;
  if (runner.folder.empty()) runner.folder = default_folder(command.options.request.scene);
  runner.program = std::filesystem::read_symlink("/proc/self/exe");
  runner.arguments = arguments_of_runs(command, plugin_folders);
  runner.interrupted = &watch_interrupts();
  runner.progress = [&bar](long done, long total) { bar.update(done, total); };
  command.options.request.variants.clear();
  for (const std::string& names : command.variants)
    for (std::string& name : split_values(names))
      command.options.request.variants.push_back(std::move(name));

  if (!command.quiet) bar.begin();
  Comparison comparison;
  try {
    comparison = compare(command.options, registry);
  } catch (...) {
    bar.end();
    throw;
  }
  bar.end();
  const AddedReport report = add_report(runner.folder);
  if (!command.quiet) {
    print_comparison(comparison, runner.folder);
    say("  report: {}\n", report.told);
  }
  const bool all_hold = print_claims(comparison.claims, command.quiet);
  if (print_failures(comparison)) return static_cast<int>(ExitCode::internal_error);
  if (report.code != ExitCode::done) return static_cast<int>(report.code);
  return static_cast<int>(all_hold ? ExitCode::done : ExitCode::expectation_failed);
}

}  // namespace deform::app
