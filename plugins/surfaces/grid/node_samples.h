/// Samples that are the nodes, as the paper has them: D_1 and D_11 along a node's row, D_2 and D_22
/// along its column, D_12 = D_1 D_2.
#pragma once

#include "differences.h"
#include "lattice.h"

namespace grid {

/// The set with its differences of fields. `weights` (N) [m²].
[[nodiscard]] deform::SampleSet node_samples(const Lattice& lattice, Scheme scheme, Border border,
                                             const deform::NodeValues& weights);

}  // namespace grid
