#pragma once

#include <filesystem>

#include "deform/simulation/scene.h"

#include "json/json.h"
#include "scene/scene_problems.h"

namespace deform {

/// Reads a scene without variants from JSON: fills in everything but Scene::file and ::variants,
/// and notes every problem (then the scene has no more than the plugins that nothing is wrong
/// with). Writes the defaults into the JSON, and drops from it what is not part of one run.
/// Relative file names start from `folder`, an absolute path.
Scene read_scene_json(Json& json, const PluginRegistry& registry,
                      const std::filesystem::path& folder, SceneProblems& problems);

}  // namespace deform
