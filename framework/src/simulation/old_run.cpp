#include "simulation/old_run.h"

#include <system_error>
#include <vector>

#include <fmt/format.h>

#include "deform/error.h"

#include "simulation/folder_lock.h"
#include "simulation/run_directory.h"

namespace deform {
namespace {

namespace fs = std::filesystem;

/// Stages of what is set aside, so that whoever finds the folder after a crash knows what is new:
/// while entries are moved nothing is; when all are, everything else; what is to be removed is
/// nobody's any more.
constexpr const char *kMoving = ".deform-old-moving", *kAside = ".deform-old",
                     *kGone = ".deform-old-gone";

void require(const std::error_code& error, const char* doing, const fs::path& what) {
  if (error)
    throw Error(ExitCode::internal_error,
                fmt::format("cannot {} {}: {}", doing, what.string(), error.message()));
}

void move_entry(const fs::path& from, const fs::path& to) {
  std::error_code error;
  fs::rename(from, to, error);
  require(error, "move", from);
}

void remove_entry(const fs::path& entry) {
  std::error_code error;
  fs::remove_all(entry, error);
  require(error, "remove", entry);
}

bool is_there(const fs::path& entry) {
  std::error_code error;
  return fs::exists(fs::symlink_status(entry, error));
}

/// All of a folder but its lock and the stages above; the manifest comes first or last: by it the
/// folder is known.
std::vector<fs::path> entries(const fs::path& folder, bool manifest_first) {
  std::vector<fs::path> found;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    const fs::path name = entry.path().filename();
    if (name == kLockFile || name == kMoving || name == kAside || name == kGone) continue;
    if (name == kManifestFile && manifest_first) {
      found.insert(found.begin(), name);
    } else if (name != kManifestFile) {
      found.push_back(name);
    }
  }
  if (!manifest_first && is_there(folder / kManifestFile)) found.emplace_back(kManifestFile);
  return found;
}

}  // namespace

bool has_old_run(const fs::path& folder) {
  return is_there(folder / kMoving) || is_there(folder / kAside);
}

void set_old_run_aside(const fs::path& folder) {
  drop_old_run(folder);
  std::error_code error;
  fs::create_directory(folder / kMoving, error);
  require(error, "make", folder / kMoving);
  for (const fs::path& name : entries(folder, false))
    move_entry(folder / name, folder / kMoving / name);
  move_entry(folder / kMoving, folder / kAside);
}

void give_old_run_back(const fs::path& folder) {
  if (is_there(folder / kAside)) {
    for (const fs::path& name : entries(folder, false)) remove_entry(folder / name);
    move_entry(folder / kAside, folder / kMoving);
  }
  if (!is_there(folder / kMoving)) return;
  for (const fs::path& name : entries(folder / kMoving, true))
    move_entry(folder / kMoving / name, folder / name);
  remove_entry(folder / kMoving);
}

void drop_old_run(const fs::path& folder) {
  remove_entry(folder / kGone);
  if (!is_there(folder / kAside)) return;
  move_entry(folder / kAside, folder / kGone);
  remove_entry(folder / kGone);
}

}  // namespace deform
