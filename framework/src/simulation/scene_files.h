/// The files that a scene names: what they hold, and what a run directory calls them.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "deform/simulation/scene.h"

#include "json/json.h"

namespace deform {

/// A file of a scene and its content's SHA-256.
struct HashedFile {
  std::string pointer;         ///< where the scene says it
  std::filesystem::path path;  ///< absolute
  std::string sha256;
};

/// Reads them all. Throws Error naming one that cannot be read.
[[nodiscard]] std::vector<HashedFile> hashed_files(const Scene& scene);
/// As a manifest lists them.
[[nodiscard]] Json json_of(const std::vector<HashedFile>& files);
/// "", or which of the files is not the one that a manifest lists, and where the scene names it.
[[nodiscard]] std::string changed_file(const Json& manifest, const std::vector<HashedFile>& files);

/// The completed scene as a run directory has it: paths start from there, so that the folder can be
/// moved together with the files that it names. Where the two have nothing but the root of the file
/// system in common, paths are absolute.
[[nodiscard]] std::string scene_text(const std::string& completed,
                                     const std::vector<SceneFile>& files,
                                     const std::filesystem::path& folder);
[[nodiscard]] std::string scene_text(const Scene& scene, const std::filesystem::path& folder);

/// A hash of all that a completed scene says about its states and their recording, of its files
/// what they hold. Scenes that differ in `duration` or `checkpoint` only have the same: a run may
/// be prolonged; and so have those whose files lie elsewhere. Empty when `completed` is not JSON.
[[nodiscard]] std::string identity_of(const std::string& completed,
                                      const std::vector<HashedFile>& files);

}  // namespace deform
