/// Coarser nodes of a grid, for multigrid methods.
#pragma once

#include <vector>

#include <deform/surface/prolongation.h>

#include "lattice.h"

namespace grid {

enum class Interpolation {
  linear,  ///< bilinear in the parameters
  /// Of bicubic B-splines, whose bending energy is that of what they interpolate; bilinear
  /// functions have kinks, which cost twice as much with each level.
  smooth,
};

/// Every second node along the direction of the closer nodes, or along both where these are about
/// as close, and the last one of an open side. From fine to coarse.
[[nodiscard]] std::vector<deform::Prolongation> coarsening(const Lattice& lattice,
                                                           Interpolation interpolation);

}  // namespace grid
