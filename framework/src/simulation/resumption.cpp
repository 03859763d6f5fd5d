#include "simulation/resumption.h"

#include <system_error>
#include <vector>

#include <fmt/format.h>

#include "deform/error.h"

#include "files/files.h"
#include "json/json_file.h"
#include "simulation/folder_lock.h"
#include "simulation/old_run.h"
#include "simulation/run_directory.h"
#include "simulation/scene_files.h"

namespace deform {
namespace {

namespace fs = std::filesystem;

Json parsed(const std::optional<std::string>& text) {
  Json json = text ? parse_json(*text) : Json();
  return json.is_discarded() ? Json() : json;
}

/// Where two scenes differ first, apart from how long and how safely they run.
std::string difference(const Json& there, const Json& here) {
  for (const Json& change : Json::diff(there, here)) {
    auto pointer = change["path"].get<std::string>();
    if (!pointer.starts_with("/duration") && !pointer.starts_with("/checkpoint")) return pointer;
  }
  return "/";
}

/// Files may lie elsewhere: what they hold is looked at by itself.
void refuse_other_scene(const fs::path& folder, const std::string& there, const Scene& scene,
                        const std::vector<HashedFile>& files) {
  if (identity_of(there, files) == identity_of(scene.completed, files)) return;
  const Json old = parsed(there);
  const std::string where = old.is_object() ? "; the first difference is at " +
                                                  difference(old, parsed(scene_text(scene, folder)))
                                            : "";
  throw InputError(fmt::format(
      "cannot resume in '{}': it holds the run of another scene (scene.json){}; --force instead of "
      "--resume replaces it",
      folder.string(), where));
}

/// Without a scene.json there may be what a run writes before it, and nothing else: what is there
/// will be removed.
void refuse_other_files(const fs::path& folder) {
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
    const fs::path name = entry.path().filename();
    if (name == kManifestFile || name == kLockFile || name == "log.txt" ||
        name.extension() == ".part" || is_of_old_run(name))
      continue;
    throw InputError(fmt::format(
        "cannot resume in '{}': it holds '{}' but no scene.json, so it is not a run directory",
        folder.string(), name.string()));
  }
}

void refuse_changed_results(const fs::path& folder, const std::string& change) {
  if (change.empty()) return;
  throw InputError(fmt::format(
      "cannot resume in '{}': {}; put back what was there, or --force instead of --resume starts "
      "the run anew",
      folder.string(), change));
}

void check(const Checkpoint& checkpoint, const fs::path& folder, const Scene& scene,
           const std::vector<HashedFile>& files) {
  const auto refuse = [&folder](const std::string& reason) {
    throw InputError(
        fmt::format("cannot resume from {}: {}", checkpoint_file(folder).string(), reason));
  };
  if (checkpoint.scene != identity_of(scene.completed, files))
    refuse("it belongs to another scene, or to other files that it names");
  if (checkpoint.step > scene.steps()) {
    refuse(fmt::format("it was written after step {}, the scene ends with step {}", checkpoint.step,
                       scene.steps()));
  }
  if (checkpoint.file("probes.csv") == nullptr) refuse("it does not know probes.csv");
  for (const WrittenFile& written : checkpoint.files)
    refuse_changed_results(folder, missing_from(folder, written));
}

}  // namespace

Resumption look_for_run(const fs::path& folder, const Scene& scene, const Manifest& now) {
  Resumption found;
  check_run_directory(folder, true);
  found.manifest = parsed(read_file(folder / kManifestFile));
  const Json status = found.manifest.is_object() ? found.manifest.value("status", Json()) : Json();
  const bool done = status == "done";
  found.planned = status == kPlanned;
  const std::optional<std::string> there = read_file(folder / "scene.json");
  if (there) {
    refuse_other_scene(folder, *there, scene, now.files());
  } else {
    refuse_other_files(folder);
  }
  found.finished = done && there == scene_text(scene, folder);
  if (found.finished) {
    refuse_changed_results(folder, now.difference(found.manifest));
    refuse_changed_results(folder, damaged_result(folder, found.manifest));
    return found;
  }
  found.checkpoint = read_checkpoint(folder);
  if (found.checkpoint) {
    refuse_changed_results(folder, now.difference(found.manifest));
    check(*found.checkpoint, folder, scene, now.files());
  } else if (done) {
    throw InputError(
        fmt::format("cannot resume in '{}': it holds a finished run and no checkpoint.bin from "
                    "which it could be prolonged; --force instead of --resume replaces it",
                    folder.string()));
  }
  return found;
}

void remove_half_written(const fs::path& folder) {
  std::vector<fs::path> files;
  std::error_code ignored;  // they are in nobody's way
  constexpr auto kOptions = fs::directory_options::skip_permission_denied;
  for (fs::recursive_directory_iterator entry(folder, kOptions, ignored), end; entry != end;
       entry.increment(ignored)) {
    if (entry->path().extension() == ".part" && entry->is_regular_file(ignored))
      files.push_back(entry->path());
  }
  for (const fs::path& file : files) fs::remove(file, ignored);
}

}  // namespace deform
