/// What a run is made of.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

#include "deform/simulation/simulation.h"

#include "simulation/recorders.h"

namespace deform {

/// Made before anything is written.
struct RunParts {
  std::unique_ptr<Simulation> simulation;
  std::optional<ProbeRecorder> probes;
  std::optional<OutputRecorder> outputs;
};

/// Throws InputError with the problems of the model, the probes and the outputs together.
[[nodiscard]] RunParts make_run_parts(const Scene& scene,
                                      const std::shared_ptr<const PluginRegistry>& registry);

/// What probes and outputs begin with; refers to the simulation.
[[nodiscard]] RunContext make_run_context(const RunParts& parts,
                                          const std::filesystem::path& folder);

/// Begins the probes. Throws InputError for what one of them rejects.
void begin_probes(RunParts& parts, const RunContext& context);

/// What is no error, though the user may not have meant it; each with its place. Of the scene as it
/// is written, and of all that is made of it.
[[nodiscard]] std::vector<Problem> remarks_on(const Scene& scene);
[[nodiscard]] std::vector<Problem> remarks_on(const RunParts& parts);

/// The problems that show when the parts of a scene are made that the reader found nothing wrong
/// with; for scenes with other problems, so that all are said at once. Empty where there is no
/// surface to make them for.
[[nodiscard]] std::vector<Problem> problems_of_sound_parts(const Scene& scene,
                                                           const PluginRegistry& registry);

}  // namespace deform
