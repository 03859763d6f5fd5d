#pragma once

#include "deform/simulation/scene.h"
#include "deform/types.h"

namespace deform {

/// (N × 3) [m/s] the velocities of all nodes at initial positions r (N × 3), with masses (N) [kg].
/// Throws InputError when a formula is not finite at a node.
[[nodiscard]] NodeVectors velocities_at_first(const InitialVelocity& velocity,
                                              const Surface& surface, const NodeValues& mass,
                                              const NodeVectors& r);

}  // namespace deform
