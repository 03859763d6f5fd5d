/// The nodes of a grid's open sides with first derivatives of second order.
#pragma once

#include "lattice.h"

namespace grid {

/// Of "left", "right", "bottom" or "top", in the order of `side`; empty where it is joined.
[[nodiscard]] std::vector<deform::EdgeNode> edge(const Lattice& lattice, const std::string& name);

}  // namespace grid
