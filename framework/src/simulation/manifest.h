/// manifest.json: what a run was made with, and how it ended.
#pragma once

#include <filesystem>
#include <string>

#include "deform/simulation/run.h"

#include "scene/json.h"

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

  /// The run goes on after `step`. Warns of plugins that are not those of the `earlier` manifest.
  void resume(long step, const Json& earlier);
  void finish(const RunResult& result, const std::string& solver_choice);
  /// The text with the status "plugin failed", and where in it the reason stands, which is "".
  struct IfProcessEnds {
    std::string before, after;
  };
  [[nodiscard]] IfProcessEnds if_process_ends() const;
  /// Throws Error when it cannot be written.
  void write(const std::filesystem::path& folder) const;

 private:
  Json json_;
};

}  // namespace deform
