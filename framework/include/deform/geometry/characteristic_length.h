/// The length that parts of a surface are measured by.
#pragma once

#include "deform/types.h"

namespace deform {

/// The longest side of the box along x, y, z around points r (N × 3, N at least 1) [m]: what
/// tolerances, limits and errors "in characteristic lengths" are relative to, mostly of its rest
/// positions.
[[nodiscard]] inline double characteristic_length(const NodeVectors& r) {
  return (r.colwise().maxCoeff() - r.colwise().minCoeff()).maxCoeff();
}

}  // namespace deform
