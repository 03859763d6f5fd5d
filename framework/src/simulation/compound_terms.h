/// Energy terms that are sums of others, taken apart.
#pragma once

#include <vector>

#include "deform/solve/system.h"

namespace deform {

/// Puts the first part of each compound term in its place and the others at the end, so that what
/// is not compound keeps its number. A part is called "koiter_bending", and keeps its compound
/// alive, and its retardation time [s], of which there is one an energy. Throws PluginFailure for a
/// compound without parts, or of compounds.
void take_apart_compounds(std::vector<Named<EnergyTerm>>& energies,
                          std::vector<double>& retardation);

}  // namespace deform
