/// Scenes: what a JSON file says, checked and complete.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "deform/export.h"
#include "deform/plugin/registry.h"
#include "deform/plugin/setup.h"

namespace deform {

/// An output or probe and how often it is due.
struct RecorderUse {
  PluginUse use;
  long every = 1;  ///< steps
};

/// A scene with defaults filled in; every plugin that it names exists and every parameter is in
/// range.
struct DEFORM_API Scene {
  std::filesystem::path file;
  std::string title;
  PluginUse surface;
  Material material;
  std::vector<PluginUse> energies, forces, constraints;
  PluginUse integrator;
  double step = 0;                  ///< [s]
  double duration = 0;              ///< [s]
  std::optional<PluginUse> solver;  ///< none: chosen by the matrix' properties
  std::vector<RecorderUse> outputs, probes;
  Vec3 velocity = Vec3::Zero();       ///< of every free node at first [m/s]
  double max_distance = 10;           ///< diverged beyond it, in sizes of the surface
  std::vector<std::string> variants;  ///< names in the order of the file; without "base"
  std::string completed;              ///< the scene as JSON text with every default written out

  [[nodiscard]] long steps() const;  ///< duration / step, rounded
};

/// A value to put at a JSON pointer before the scene is checked (`--set`); the text is JSON, else a
/// string.
struct Replacement {
  std::string pointer;
  std::string value;
};

/// Reads and checks a scene. Throws InputError with every problem of the file, each with
/// `FILE:LINE:COLUMN` where it has a place.
[[nodiscard]] DEFORM_API Scene read_scene(const std::filesystem::path& file,
                                          const PluginRegistry& registry,
                                          const std::vector<Replacement>& replacements = {},
                                          const std::string& variant = "base");
/// The same for text; relative file names start from `folder`.
[[nodiscard]] DEFORM_API Scene read_scene_text(const std::string& text, const std::string& name,
                                               const std::filesystem::path& folder,
                                               const PluginRegistry& registry,
                                               const std::vector<Replacement>& replacements = {},
                                               const std::string& variant = "base");

}  // namespace deform
