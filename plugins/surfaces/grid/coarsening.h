/// Coarser nodes of a grid, for multigrid methods.
#pragma once

#include <vector>

#include <deform/surface/prolongation.h>

#include "lattice.h"

namespace grid {

/// Every second node along the direction of the closer nodes, or along both where these are about
/// as close, and the last one of an open side; bilinear in the parameters. From fine to coarse.
[[nodiscard]] std::vector<deform::Prolongation> coarsening(const Lattice& lattice);

}  // namespace grid
