/// Energies of strains that are averaged over a step (StepStrains::average_from).
#pragma once

#include <vector>

#include "deform/types.h"

#include "solve/assembly/model_terms.h"

namespace deform {

/// Energies [J] of a term's tuples as the step's middle has them: half of those at its end, whose
/// negative gradients with respect to the middle are the forces there.
[[nodiscard]] std::vector<double> mean_energies(const TupleAssembler& term, const Strains& strains);
/// Adds the forces of what is averaged, which conserve energy and momenta; strains of the middle
/// `now` (Strains::update_mean).
void add_forces_of_mean_strains(ModelTerms& terms, const StateGeometry& now, Strains* strains,
                                NodeVectors& f);
/// Adds the gradient, with respect to the middle, of the energy of the mean strains, W((T + T⁺)/2),
/// whose derivatives are those of the end's T⁺.
void add_gradient_of_mean_energy(ModelTerms& terms, Strains* strains, NodeVectors& f);

}  // namespace deform
