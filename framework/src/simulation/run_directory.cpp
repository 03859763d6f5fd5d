#include "simulation/run_directory.h"

#include <fstream>
#include <string>
#include <system_error>

#include <fmt/format.h>

#include "deform/error.h"

#include "scene/json.h"

namespace deform {
namespace {

namespace fs = std::filesystem;

constexpr const char* kManifest = "manifest.json";

void remove_tree(const fs::path& entry) {
  std::error_code error;
  fs::remove_all(entry, error);
  if (error) {
    throw Error(ExitCode::internal_error,
                fmt::format("cannot remove {}: {}", entry.string(), error.message()));
  }
}

/// True also where a run was killed while it wrote its first file.
bool holds_nothing(const fs::path& folder, std::error_code& error) {
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
    if (entry.path().filename() != std::string(kManifest) + ".part") return false;
  }
  return true;
}

/// The manifest goes last: a folder that was emptied only half is still known as one of ours.
void empty(const fs::path& folder) {
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    if (entry.path().filename() != kManifest) remove_tree(entry.path());
  }
  remove_tree(folder / kManifest);
}

}  // namespace

bool has_manifest(const fs::path& folder) {
  std::ifstream in(folder / kManifest);
  if (!in) return false;
  const Json manifest = Json::parse(in, nullptr, false);
  return manifest.is_object() && manifest.contains("program") && manifest["program"].is_string() &&
         manifest["program"] == "deform";
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
  const bool is_empty = holds_nothing(folder, error);
  if (error) {
    throw InputError(fmt::format("cannot look into '{}': {}", folder.string(), error.message()));
  }
  if (!is_empty && !has_manifest(folder)) {
    throw InputError(fmt::format(
        "'{}' is not replaced even with --force: it holds no manifest.json of deform, so it is not "
        "a run directory",
        folder.string()));
  }
}

void make_run_directory(const fs::path& folder) {
  std::error_code error;
  if (fs::is_directory(folder, error)) {
    empty(folder);
    return;
  }
  fs::create_directories(folder, error);
  if (error) {
    throw Error(ExitCode::internal_error,
                fmt::format("cannot make {}: {}", folder.string(), error.message()));
  }
}

}  // namespace deform
