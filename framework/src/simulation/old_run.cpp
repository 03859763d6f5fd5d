#include "simulation/old_run.h"

#include <string>
#include <system_error>
#include <vector>

#include <fmt/format.h>

#include "deform/error.h"
#include "deform/log.h"

#include "simulation/folder_lock.h"
#include "simulation/run_directory.h"

namespace deform {
namespace {

namespace fs = std::filesystem;

/// Stages of what is set aside, so that whoever finds the folder after a crash knows what is new:
/// while entries are moved nothing is; when all are, everything else; what is to be removed is
/// nobody's any more. Where some of that cannot be, the next has a number behind the name.
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
    if (name == kLockFile || is_of_old_run(name)) continue;
    if (name == kManifestFile && manifest_first) {
      found.insert(found.begin(), name);
    } else if (name != kManifestFile) {
      found.push_back(name);
    }
  }
  if (!manifest_first && is_there(folder / kManifestFile)) found.emplace_back(kManifestFile);
  return found;
}

/// A name for what is to be removed that nothing has.
fs::path unused_name(const fs::path& folder) {
  fs::path file = folder / kGone;
  for (int number = 2; is_there(file); ++number)
    file = folder / fmt::format("{}-{}", kGone, number);
  return file;
}

/// Removes what is nobody's, as far as possible; returns why some of it stays, or "".
std::string remove_given_up(const fs::path& folder) {
  std::error_code error;
  std::vector<fs::path> found;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error))
    if (is_given_up(entry.path().filename())) found.push_back(entry.path());
  std::string why;
  for (const fs::path& entry : found) {
    fs::remove_all(entry, error);
    if (error) why = fmt::format("cannot remove {}: {}", entry.string(), error.message());
  }
  return why;
}

}  // namespace

bool is_given_up(const fs::path& name) { return name.string().starts_with(kGone); }

bool is_of_old_run(const fs::path& name) {
  return name == kMoving || name == kAside || is_given_up(name);
}

bool has_old_run(const fs::path& folder) {
  return is_there(folder / kMoving) || is_there(folder / kAside);
}

void set_old_run_aside(const fs::path& folder) {
  require_unheld_within(folder);
  std::error_code error;
  fs::create_directory(folder / kMoving, error);
  require(error, "make", folder / kMoving);
  for (const fs::path& name : entries(folder, false))
    move_entry(folder / name, folder / kMoving / name);
  move_entry(folder / kMoving, folder / kAside);
}

void give_old_run_back(const fs::path& folder) {
  if (is_there(folder / kAside)) {
    require_unheld_within(folder);
    for (const fs::path& name : entries(folder, false)) remove_entry(folder / name);
    move_entry(folder / kAside, folder / kMoving);
  }
  if (is_there(folder / kMoving)) {
    for (const fs::path& name : entries(folder / kMoving, true))
      move_entry(folder / kMoving / name, folder / name);
    remove_entry(folder / kMoving);
  }
  if (const std::string why = remove_given_up(folder); !why.empty()) log::debug(why);
}

void drop_old_run(const fs::path& folder) {
  if (!is_there(folder / kAside)) return;
  move_entry(folder / kAside, unused_name(folder));
  if (const std::string why = remove_given_up(folder); !why.empty())
    log::warn(fmt::format("of the run that was here before something stays: {}", why));
}

}  // namespace deform
