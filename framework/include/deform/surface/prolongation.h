/// Interpolation from fewer nodes to more, as multigrid methods need it.
#pragma once

#include <cstdint>
#include <vector>

#include "deform/types.h"

namespace deform {

/// P (fine × coarse) in compressed rows: a field on the fine nodes from one on coarser ones. The
/// weights of a row sum to 1. A fine node that is a coarse one has it alone in its row; where the
/// interpolation is smooth (Surface::smooth_coarsening) coarse values are coefficients rather than
/// values, and such a node has more than half of its row from that one.
struct Prolongation {
  Index coarse = 0;                    ///< number of coarse nodes
  std::vector<std::int32_t> begin{0};  ///< (fine + 1)
  std::vector<std::int32_t> node;      ///< coarse nodes
  std::vector<double> weight;
};

}  // namespace deform
