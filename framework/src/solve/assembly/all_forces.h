/// The sum of all forces on the nodes.
#pragma once

#include "deform/solve/state.h"
#include "deform/types.h"

#include "solve/assembly/assembly.h"

namespace deform {

/// Makes f (N × 3) [N] the sum of all forces at a state, numbers that are not finite included.
/// `part`: what else terms compute. Returns the state's geometry.
std::shared_ptr<const StateGeometry> sum_all_forces(Assembly& assembly, const State& state,
                                                    Strains* strains, JetAssembler::Part part,
                                                    NodeVectors& f);

}  // namespace deform
