/// The motions of a surface as a rigid body that its constraints leave free.
#pragma once

#include <vector>

#include "deform/model/reduction.h"
#include "deform/types.h"

namespace deform {

/// As many free components as there are such motions at positions r (N × 3) [m], chosen so that
/// holding them holds the surface: none where the constraints do. Holding them changes no strain.
[[nodiscard]] std::vector<Freedom> components_to_hold(const ReductionMap& map,
                                                      const NodeVectors& r);

}  // namespace deform
