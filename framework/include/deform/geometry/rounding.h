/// What double precision leaves undecided of positions.
#pragma once

#include <limits>

#include "deform/types.h"

namespace deform {

/// Distances below this are rounding of positions r (N × 3) [m]: a few units in the last place of
/// the largest coordinate, which far from the origin is much more than of the surface's size.
[[nodiscard]] inline double rounding_of_positions(const NodeVectors& r) {
  constexpr double kUnits = 4;
  return r.size() == 0 ? 0
                       : kUnits * std::numeric_limits<double>::epsilon() * r.cwiseAbs().maxCoeff();
}

}  // namespace deform
