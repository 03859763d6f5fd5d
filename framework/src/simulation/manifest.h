/// manifest.json: what a run was made with, and how it ended.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "deform/simulation/run.h"

#include "files/files.h"
#include "json/json.h"
#include "simulation/scene_files.h"

namespace deform {

/// The time of day, UTC: "2024-05-06T07:08:09Z".
[[nodiscard]] std::string utc_now();

/// The status of a run that has not begun: its folder is there, and its scene.
inline constexpr const char* kPlanned = "planned";
/// What makes such a folder known as one of deform's, as text.
[[nodiscard]] std::string planned_manifest();

/// Written when a run starts, with the status "running", and again when it ends.
class Manifest {
 public:
  Manifest(const Scene& scene, const PluginRegistry& registry, const RunOptions& options);

  /// "", or what the run of an `earlier` manifest was made with that is another now: the program,
  /// a plugin, a file of the scene.
  [[nodiscard]] std::string difference(const Json& earlier) const;
  [[nodiscard]] const Json& json() const { return json_; }
  /// The files that the scene names, as they were when this was made.
  [[nodiscard]] const std::vector<HashedFile>& files() const { return files_; }

  /// The run goes on after `step`.
  void resume(long step);
  /// A file that the run has written to its end.
  void add_result(const WrittenFile& file);
  void finish(const RunResult& result, const std::string& solver_choice);
  /// The text with the status "plugin failed", and where in it the reason stands, which is "".
  struct IfProcessEnds {
    std::string before, after;
  };
  [[nodiscard]] IfProcessEnds if_process_ends() const;
  /// Throws Error when it cannot be written.
  void write(const std::filesystem::path& folder) const;

 private:
  std::vector<HashedFile> files_;
  Json json_;
};

/// A file of a run directory that is not what its manifest says that the run has written.
struct DamagedResult {
  std::string file;  ///< its name; empty where the manifest's list itself is damaged
  std::string why;
};
/// Nothing is known of a run that has not ended. Throws Error when a file cannot be read.
[[nodiscard]] std::vector<DamagedResult> damaged_results(const std::filesystem::path& folder,
                                                         const Json& manifest);
/// Of the first of them: why; "" where there is none.
[[nodiscard]] std::string damaged_result(const std::filesystem::path& folder, const Json& manifest);

}  // namespace deform
