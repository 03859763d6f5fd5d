/// Masses of nodes, from what the scene and its energies' materials say.
#pragma once

#include "deform/simulation/scene.h"
#include "deform/solve/system.h"

#include "simulation/part_maker.h"

namespace deform {

/// (N) mass per area [kg/m²]: the scene's density where it is given, else that of the energies'
/// materials, which the log is told of where it `tells`, else the scene's default. Notes where two
/// of the materials disagree.
[[nodiscard]] NodeValues densities(const Scene& scene, Index nodes,
                                   const std::vector<Named<EnergyTerm>>& energies, PartMaker& maker,
                                   bool tells);

/// Notes where a node stands for no area, so that it would have no mass.
void check_areas(const Scene& scene, const NodeValues& areas, PartMaker& maker);

}  // namespace deform
