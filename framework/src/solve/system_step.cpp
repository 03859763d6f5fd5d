/// The part of a System that averages strains over a step, so that energy and momenta are
/// conserved.
#include <algorithm>

#include "solve/system_impl.h"

namespace deform {

void System::average_strains_from(const NodeVectors& r) {
  impl_->averages_strains = true;
  impl_->step_from = r;
  impl_->mean_at.resize(0, 3);
  impl_->damped_at.resize(0, 3);
  for (SetPart& set : impl_->sets) {
    if (set.from.size() == 0) set.from = set.to = Geometry(set.assembler.samples());
    set.compute(set.from, r);
  }
  impl_->tuple_energies.clear();
  for (const TupleAssembler& t : impl_->tuples)
    impl_->tuple_energies.push_back(t.has_potential() ? t.energies(r) : std::vector<double>());
}

void System::end_average_of_strains() {
  if (!impl_->averages_strains) return;
  impl_->averages_strains = false;
  impl_->damped_at.resize(0, 3);
}

bool System::Impl::knows_strains() const {
  return std::ranges::any_of(traits, [](const TermTraits& t) { return t.strains; }) ||
         std::ranges::any_of(tuples, [](const TupleAssembler& t) { return t.has_potential(); });
}

void System::Impl::evaluate_tuples(const NodeVectors& r) {
  if (averages_strains) update_geometry(r);  // for the step's end
  for (std::size_t i = 0; i < tuples.size(); ++i) {
    TupleAssembler& t = tuples[i];
    if (averages_strains && t.has_potential())
      t.evaluate_over_step(step_from, r, step_to, tuple_energies[i]);
    else
      t.evaluate(r, r);
  }
}

/// Half of those at the step's end: with respect to its middle they have the forces there for
/// negative gradients.
std::vector<double> System::Impl::mean_energies(const TupleAssembler& term, const NodeVectors& r) {
  if (!term.has_potential()) return term.energies(r);
  update_geometry(r);  // for the step's end
  std::vector<double> energies = term.energies(step_to);
  for (double& e : energies) e *= 0.5;
  return energies;
}

/// Of what is averaged, at the updated geometry.
void System::Impl::add_strain_forces(NodeVectors& f) {
  for (SetPart& set : sets)
    for (const JetAssembler::Term& term : set.assembler.terms()) {
      if (!term.traits.strains) continue;
      set.assembler.evaluate(geometries(set), JetAssembler::Part::stress, &term);
      set.assembler.add_force(f);
    }
  evaluate_tuples(mean_at);
  for (const TupleAssembler& t : tuples)
    if (t.has_potential()) t.add_force(f);
}

/// Adds the gradient, with respect to the middle, of the energy of the mean strains, W((T + T⁺)/2),
/// whose derivatives are those of the end's T⁺.
void System::Impl::add_gradient_of_mean_energy(NodeVectors& f) {
  NodeVectors gradient = NodeVectors::Zero(f.rows(), 3);
  for (SetPart& set : sets) {
    if (!set.to.has_mean_strains()) set.to.average_forms(set.from);
    for (const JetAssembler::Term& term : set.assembler.terms()) {
      if (!term.traits.strains) continue;
      set.assembler.evaluate({set.to, set.to, set.rest}, JetAssembler::Part::stress, &term);
      set.assembler.add_force(gradient);
    }
  }
  for (TupleAssembler& t : tuples) {
    if (!t.has_potential()) continue;
    t.evaluate(step_to, step_to);
    t.add_force(gradient);
  }
  f -= gradient;
}

}  // namespace deform
