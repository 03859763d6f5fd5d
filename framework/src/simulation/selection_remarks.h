/// Selections whose nodes are not quite the region that a scene describes.
#pragma once

#include <vector>

#include "deform/simulation/scene.h"
#include "deform/surface/surface.h"

namespace deform {

/// A remark, with its pointer, for each patch (a `centre` with its radius, a `box`) of a force or
/// constraint that is off by more than a tenth of its area: of forces the areas of nodes that are
/// taken, of constraints the extent of the nodes that are held. Nodes, sides and lines are no
/// areas, nor is a patch that is smaller than a cell: it is meant to be a node.
[[nodiscard]] std::vector<Problem> selection_remarks(const Scene& scene, const Surface& surface);

/// Logs them as information, each once however many simulations a program makes of a scene and its
/// variants.
void log_selection_remarks(const Scene& scene, const Surface& surface);

}  // namespace deform
