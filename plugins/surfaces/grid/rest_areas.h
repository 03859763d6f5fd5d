/// Areas and lengths of a shape over a grid, by smooth interpolation of its nodes.
#pragma once

#include "lattice.h"

namespace grid {

/// (N) [m²]: `areas` times the mean area element |r_1 × r_2| around each node, of the surface
/// through the nodes r that is a polynomial of fifth degree along every line around each cell: to
/// 0.1 % with nine nodes around a circle. Cells in which polynomials of higher degree do not settle
/// (at creases, of measured shapes) are bilinear instead.
/// Exactly `areas` where that element is 1 but for rounding.
[[nodiscard]] deform::NodeValues rest_areas(const Lattice& lattice, const deform::NodeValues& areas,
                                            const deform::NodeVectors& r);
/// The same along the nodes of a side: `lengths` [m] times the mean of |dr/da| around each.
[[nodiscard]] std::vector<double> rest_lengths(const std::vector<Index>& side, double h,
                                               bool periodic, const std::vector<double>& lengths,
                                               const deform::NodeVectors& r);

}  // namespace grid
