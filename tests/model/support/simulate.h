/// Runs scenes inside a test.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "deform/simulation/simulation.h"

namespace deform::test {

inline std::shared_ptr<const PluginRegistry> built_in() {
  static const auto registry = std::make_shared<const PluginRegistry>();
  return registry;
}

inline std::filesystem::path scene_file(const std::string& name) {
  return std::filesystem::path(DEFORM_SCENES) / name;
}

inline Simulation simulation_of(const std::string& scene, const std::string& variant = "base",
                                const std::vector<Replacement>& replacements = {}) {
  return {read_scene(scene_file(scene), *built_in(), replacements, variant), built_in()};
}

inline Simulation simulation_from_text(const std::string& text,
                                       const std::vector<Replacement>& replacements = {}) {
  return {read_scene_text(text, "test scene", ".", *built_in(), replacements), built_in()};
}

/// Steps to the scene's end; returns the divergence that ended it early, if one did.
inline std::optional<Diverged> run_to_end(Simulation& simulation) {
  try {
    while (simulation.steps() < simulation.scene().steps()) simulation.step();
  } catch (const Diverged& diverged) {
    return diverged;
  }
  return std::nullopt;
}

}  // namespace deform::test
