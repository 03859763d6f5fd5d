/// What a run directory offers to a run that is to be resumed in it.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "deform/simulation/scene.h"

#include "json/json.h"
#include "simulation/checkpoint.h"
#include "simulation/manifest.h"

namespace deform {

struct Resumption {
  bool finished = false;                 ///< the scene's run is there, to its end
  bool planned = false;                  ///< nothing is there yet but the scene
  std::optional<Checkpoint> checkpoint;  ///< none: the run starts anew
  Json manifest;                         ///< of the run so far; null where there is none
};

/// Looks, changes nothing. Throws InputError naming file and reason where the folder holds
/// something else than a run, the run of another scene, what was made with another program, plugin
/// or file (`now`: what it would be made with), a checkpoint that cannot be used, or files that are
/// not what the run has written.
[[nodiscard]] Resumption look_for_run(const std::filesystem::path& folder, const Scene& scene,
                                      const Manifest& now);

/// Removes the temporary files of writes that were cut off.
void remove_half_written(const std::filesystem::path& folder);

}  // namespace deform
