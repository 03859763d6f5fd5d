#include "simulation/run_directory.h"

#include <exception>
#include <string>
#include <system_error>

#include <fmt/format.h>

#include "deform/error.h"

#include "json/json.h"
#include "json/json_file.h"
#include "simulation/folder_lock.h"
#include "simulation/old_run.h"

namespace deform {
namespace {

namespace fs = std::filesystem;

void remove_tree(const fs::path& entry) {
  std::error_code error;
  fs::remove_all(entry, error);
  if (error) {
    throw Error(ExitCode::internal_error,
                fmt::format("cannot remove {}: {}", entry.string(), error.message()));
  }
}

}  // namespace

bool has_manifest(const fs::path& folder) {
  try {
    return read_json_object(folder / kManifestFile).value("program", Json()) == "deform";
  } catch (const std::exception&) {  // it is no file, or none that may be read, or no object
    return false;
  }
}

bool holds_nothing(const fs::path& folder) {
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
    const fs::path name = entry.path().filename();
    const bool is_nothing =
        name == std::string(kManifestFile) + ".part" || name == kLockFile || is_given_up(name);
    if (!is_nothing) return false;
  }
  if (error)
    throw InputError(fmt::format("cannot look into '{}': {}", folder.string(), error.message()));
  return true;
}

void check_run_directory(const fs::path& folder, bool force) {
  std::error_code error;
  const fs::file_status status = fs::status(folder, error);
  if (!fs::exists(status)) {
    if (error && status.type() != fs::file_type::not_found) {
      throw InputError(fmt::format("cannot look at '{}': {}", folder.string(), error.message()));
    }
    return;
  }
  if (!fs::is_directory(status)) {
    throw InputError(fmt::format("'{}' exists and is not a folder", folder.string()));
  }
  if (!force) {
    throw InputError(
        fmt::format("'{}' exists; --force replaces it, --out names another", folder.string()));
  }
  if (!holds_nothing(folder) && !has_manifest(folder) && !has_old_run(folder)) {
    throw InputError(fmt::format(
        "'{}' is not replaced even with --force: it holds no manifest.json of deform, so it is not "
        "a run directory",
        folder.string()));
  }
}

void make_run_directory(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) {
    throw Error(ExitCode::internal_error,
                fmt::format("cannot make {}: {}", folder.string(), error.message()));
  }
}

/// The manifest goes last: a folder that was emptied only half is still known as one of ours.
void empty_run_directory(const fs::path& folder) {
  require_unheld_within(folder);
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    const fs::path name = entry.path().filename();
    if (name != kManifestFile && name != kLockFile && !is_given_up(name)) remove_tree(entry.path());
  }
  remove_tree(folder / kManifestFile);
}

}  // namespace deform
