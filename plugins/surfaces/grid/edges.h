/// The nodes of a grid's open sides with first derivatives of second order.
#pragma once

#include "lattice.h"

namespace grid {

/// Of "left", "right", "bottom" or "top", in the order of `side`, with the lengths of the rest
/// shape (N × 3) [m]; empty where it is joined.
[[nodiscard]] std::vector<deform::EdgeNode> edge(const Lattice& lattice,
                                                 const deform::NodeVectors& rest,
                                                 const std::string& name);

}  // namespace grid
