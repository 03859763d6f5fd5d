/// Fewer and fewer nodes, for multigrid.
#pragma once

#include <vector>

#include <deform/surface/prolongation.h>

#include "triangles.h"

namespace mesh {

/// Coarse nodes are as many of the finer ones as have no edge in common (a maximal independent set,
/// taken in the order of the nodes); every other node is the mean of the coarse ones beside it,
/// weighted by 1/distance at rest. Two coarse nodes have an edge where a finer one is beside both.
/// From some levels to a few dozen nodes, a third to a quarter of those before each; none where the
/// mesh is small.
[[nodiscard]] std::vector<deform::Prolongation> coarsening(const Triangles& t);

}  // namespace mesh
