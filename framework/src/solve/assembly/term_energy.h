/// Energies of single terms and of all force fields.
#pragma once

#include <cstddef>
#include <vector>

#include "deform/solve/state.h"
#include "deform/types.h"

#include "solve/assembly/model_terms.h"

namespace deform {

/// Of one term at positions r (N × 3) [J].
[[nodiscard]] double term_energy(ModelTerms& terms, std::size_t term, const NodeVectors& r,
                                 Strains* strains);
/// Energy per parameter area [J/m²] at the samples of a JetTerm's set, to `density`, which is empty
/// for other terms.
void find_energy_density(ModelTerms& terms, std::size_t term, const StateGeometry& now,
                         Strains* strains, std::vector<double>& density);
/// Of the force fields that have one [J].
[[nodiscard]] double external_potential(ModelTerms& terms, const State& state);

}  // namespace deform
