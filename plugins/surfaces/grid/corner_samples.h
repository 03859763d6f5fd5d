/// Samples at the four corners of every cell, seen as a bilinear element with quadrature at its
/// vertices.
#pragma once

#include "lattice.h"

namespace grid {

/// A sample sits at its corner's node: r_1 and r_2 are the cell's two edges that meet there, D_12
/// is the cell's, r_11 and r_22 do not exist; its weight is a quarter of the cell.
///
/// A one-sided difference is of first order, but an edge's is of second order at the edge's middle,
/// and of a cell's four corners the errors cancel: integrals over the samples are of second order,
/// at the border, too. No displacement that alternates from node to node is without strain here.
[[nodiscard]] deform::SampleSet corner_samples(const Lattice& lattice);

}  // namespace grid
