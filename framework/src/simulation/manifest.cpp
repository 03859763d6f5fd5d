#include "simulation/manifest.h"

#include <algorithm>
#include <array>
#include <ctime>
#include <set>
#include <string>
#include <thread>
#include <unistd.h>

#include <Eigen/Core>
#include <fmt/chrono.h>
#include <fmt/format.h>
#include <sys/resource.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include "deform/log.h"
#include "deform/version.h"

#include "simulation/files.h"
#include "simulation/plugins_used.h"
#include "simulation/sha256.h"

namespace deform {
namespace {

std::string host_name() {
  std::array<char, 256> name{};
  return ::gethostname(name.data(), name.size() - 1) == 0 ? name.data() : "";
}

int threads() {
  // A limit on the whole program does not show in the arena.
  const auto allowed =
      tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism);
  return std::min(static_cast<int>(allowed), tbb::this_task_arena::max_concurrency());
}

/// Largest resident memory of this process so far [MB].
double peak_memory() {
  rusage usage{};
  return ::getrusage(RUSAGE_SELF, &usage) == 0 ? static_cast<double>(usage.ru_maxrss) / 1024 : 0;
}

Json versions() {
  return {{"compiler", fmt::format("{} {}",
#if defined(__clang__)
                                   "clang++",
#else
                                   "g++",
#endif
                                   __VERSION__)},
          {"eigen",
           fmt::format("{}.{}.{}", EIGEN_WORLD_VERSION, EIGEN_MAJOR_VERSION, EIGEN_MINOR_VERSION)}};
}

Json describe(const LoadedPlugin& plugin) {
  return {{"kind", name_of(plugin.file().kind)},
          {"name", plugin.file().name},
          {"version", plugin.descriptor().text.version},
          {"file", plugin.file().path.string()},
          {"sha256", sha256_of_file(plugin.file().path)}};
}

}  // namespace

std::string utc_now() {
  return fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(std::time(nullptr)));
}

const char* status_of(ExitCode code) {
  switch (code) {
    case ExitCode::done:
      return "done";
    case ExitCode::diverged:
      return "diverged";
    case ExitCode::plugin_failed:
      return "plugin failed";
    case ExitCode::interrupted:
      return "interrupted";
    default:
      return "failed";
  }
}

std::string planned_manifest() {
  return Json({{"program", "deform"}, {"version", version()}, {"status", kPlanned}}).dump(2) + '\n';
}

Manifest::Manifest(const Scene& scene, const PluginRegistry& registry, const RunOptions& options) {
  // "program" is what makes the folder known as one of deform's: has_manifest().
  json_["program"] = "deform";
  json_["version"] = version();
  json_["status"] = "running";
  json_["exit_code"] = nullptr;
  json_["reason"] = "";
  json_["title"] = scene.title;
  json_["variant"] = scene.variant;
  json_["scene"] = std::filesystem::absolute(scene.file).string();
  json_["command_line"] = options.command_line;
  json_["started"] = utc_now();
  json_["resumed_after_step"] = nullptr;
  json_["host"] = host_name();
  json_["cpus"] = std::thread::hardware_concurrency();
  json_["threads"] = threads();
  json_["built_with"] = versions();
  json_["plugins"] = Json::array();
  for (const LoadedPlugin* plugin : plugins_used(scene, registry)) {
    json_["plugins"].push_back(describe(*plugin));
  }
}

void Manifest::resume(long step, const Json& earlier) {
  json_["resumed_after_step"] = step;
  std::set<std::string> known;
  const Json plugins = earlier.is_object() ? earlier.value("plugins", Json::array()) : Json();
  for (const Json& plugin : plugins) {
    if (plugin.is_object()) known.insert(plugin.value("sha256", Json()).dump());
  }
  for (const Json& plugin : json_["plugins"]) {
    if (known.contains(plugin["sha256"].dump())) continue;
    log::warn(
        fmt::format("{} is not the file that the run began with: the result may differ from "
                    "that of a run without interruption",
                    plugin["file"].get<std::string>()));
  }
}

void Manifest::finish(const RunResult& result, const std::string& solver_choice) {
  json_["status"] = status_of(result.code);
  json_["exit_code"] = static_cast<int>(result.code);
  json_["reason"] = result.reason;
  json_["solver"] = solver_choice;
  json_["steps"] = result.steps;
  json_["wall_seconds"] = result.wall_seconds;
  json_["steps_timed"] = result.steps - result.resumed_after;
  json_["peak_memory_MB"] = peak_memory();
  const StepTimes& t = result.times;
  json_["seconds"] = {
      {"all_steps", result.stepping_seconds}, {"geometry", t.geometry}, {"assembly", t.assembly},
      {"factorisation", t.factorisation},     {"solve", t.solve},       {"output", t.output}};
}

namespace {

/// A host or file name need not be UTF-8.
std::string text_of(const Json& json) {
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + '\n';
}

}  // namespace

Manifest::IfProcessEnds Manifest::if_process_ends() const {
  constexpr std::string_view kPlace = "\"reason\": \"\"";
  Json json = json_;
  json["status"] = status_of(ExitCode::plugin_failed);
  json["exit_code"] = static_cast<int>(ExitCode::plugin_failed);
  json["reason"] = "";
  const std::string text = text_of(json);
  const std::size_t place = text.find(kPlace) + kPlace.size();
  return {text.substr(0, place - 2), text.substr(place)};
}

void Manifest::write(const std::filesystem::path& folder) const {
  write_atomically(folder / "manifest.json", text_of(json_));
}

}  // namespace deform
