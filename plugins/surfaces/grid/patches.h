/// Areas of a grid's nodes within rectangles of the parameters.
#pragma once

#include "lattice.h"

namespace grid {

/// (N) [m²]: ∫ φ_a over the union of the rectangles, with the bilinear φ_a that is 1 at node a and
/// 0 at all others: the loads by which a load per area on the patch does the work of a surface that
/// is bilinear in each cell. Their sum is the union's area within the grid, Σ a of theirs is its
/// first moment. Whole cells give what `areas` does.
[[nodiscard]] deform::NodeValues areas_within(
    const Lattice& lattice, const std::vector<deform::ParameterRectangle>& rectangles);

}  // namespace grid
