#include "simulation/manifest.h"

#include <algorithm>
#include <ctime>
#include <set>
#include <string>
#include <system_error>
#include <thread>
#include <utility>

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <sys/resource.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include "deform/version.h"

#include "files/sha256.h"
#include "simulation/machine.h"
#include "simulation/plugins_used.h"
#include "simulation/run_directory.h"

namespace deform {
namespace {

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

Json describe(const LoadedPlugin& plugin) {
  return {{"kind", name_of(plugin.file().kind)},
          {"name", plugin.file().name},
          {"version", plugin.descriptor().text.version},
          {"file", plugin.file().path.string()},
          {"sha256", sha256_of_file(plugin.file().path)}};
}

/// The hashes of a list of files; empty of what is no such list.
std::set<std::string> hashes_of(const Json& manifest, const char* key) {
  std::set<std::string> hashes;
  const auto list = manifest.find(key);
  if (list == manifest.end() || !list->is_array()) return hashes;
  for (const Json& file : *list) {
    if (file.is_object()) hashes.insert(file.value("sha256", Json()).dump());
  }
  return hashes;
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

std::vector<DamagedResult> damaged_results(const std::filesystem::path& folder,
                                           const Json& manifest) {
  const auto results = manifest.find("results");
  if (results == manifest.end() || !results->is_array()) return {};
  std::vector<DamagedResult> damaged;
  for (const Json& result : *results) {
    const bool is_one = result.is_object() && result.value("file", Json()).is_string() &&
                        result.value("bytes", Json()).is_number_unsigned() &&
                        result.value("sha256", Json()).is_string();
    if (!is_one) {
      damaged.push_back({"", (folder / kManifestFile).string() + " lists what is no file"});
      continue;
    }
    const WrittenFile file{std::filesystem::path(result["file"].get<std::string>()).filename(),
                           result["bytes"].get<std::uint64_t>(),
                           result["sha256"].get<std::string>()};
    std::string why = missing_from(folder, file);
    std::error_code error;
    if (why.empty() && std::filesystem::file_size(folder / file.name, error) != file.bytes)
      why = fmt::format("{} is longer than what was written", (folder / file.name).string());
    if (!why.empty()) damaged.push_back({file.name, std::move(why)});
  }
  return damaged;
}

std::string damaged_result(const std::filesystem::path& folder, const Json& manifest) {
  const std::vector<DamagedResult> damaged = damaged_results(folder, manifest);
  return damaged.empty() ? "" : damaged.front().why;
}

std::string planned_manifest() {
  return Json({{"program", "deform"}, {"version", version()}, {"status", kPlanned}}).dump(2) + '\n';
}

Manifest::Manifest(const Scene& scene, const PluginRegistry& registry, const RunOptions& options)
    : files_(hashed_files(scene)) {
  // "program" is what makes the folder known as one of deform's: has_manifest().
  json_["program"] = "deform";
  json_["version"] = version();
  json_["commit"] = options.commit.empty() ? Json() : Json(options.commit);
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
  json_["cpu"] = cpu_model();
  json_["cpus"] = std::thread::hardware_concurrency();
  json_["threads"] = threads();
  json_["built_with"] = built_with();
  json_["library"] = own_library();
  json_["files"] = json_of(files_);
  json_["plugins"] = Json::array();
  for (const LoadedPlugin* plugin : plugins_used(scene, registry)) {
    json_["plugins"].push_back(describe(*plugin));
  }
}

std::string Manifest::difference(const Json& earlier) const {
  if (!earlier.is_object()) return "its manifest.json does not say what it was made with";
  const std::string there = earlier.value("version", Json()).dump(), here = json_["version"].dump();
  if (there != here)
    return fmt::format("it was made by version {} of the program, this is {}", there, here);
  const Json library = earlier.value("library", Json());
  if (!library.is_object() || library.value("sha256", Json()) != json_["library"]["sha256"])
    return "it was made by another build of the program";
  const std::set<std::string> known = hashes_of(earlier, "plugins");
  for (const Json& plugin : json_["plugins"]) {
    if (!known.contains(plugin["sha256"].dump()))
      return fmt::format("{} is not the plugin file that it was made with",
                         plugin["file"].get<std::string>());
  }
  if (known.size() != hashes_of(json_, "plugins").size()) return "it was made with other plugins";
  return changed_file(earlier, files_);
}

void Manifest::resume(long step) { json_["resumed_after_step"] = step; }

void Manifest::finish(const RunResult& result, const std::string& solver_choice) {
  json_["status"] = status_of(result.code);
  json_["exit_code"] = static_cast<int>(result.code);
  json_["reason"] = result.reason;
  json_["solver"] = solver_choice;
  json_["libraries"] = loaded_libraries();
  json_["steps"] = result.steps;
  json_["wall_seconds"] = result.wall_seconds;
  json_["steps_timed"] = result.steps - result.resumed_after;
  json_["peak_memory_MB"] = peak_memory();
  const StepTimes& t = result.times;
  json_["seconds"] = {
      {"all_steps", result.stepping_seconds}, {"geometry", t.geometry}, {"assembly", t.assembly},
      {"factorisation", t.factorisation},     {"solve", t.solve},       {"output", t.output}};
}

void Manifest::add_result(const WrittenFile& file) {
  json_["results"].push_back({{"file", file.name}, {"bytes", file.bytes}, {"sha256", file.sha256}});
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
  write_atomically(folder / kManifestFile, text_of(json_));
}

}  // namespace deform
