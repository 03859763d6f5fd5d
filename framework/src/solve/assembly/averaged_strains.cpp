#include "solve/assembly/averaged_strains.h"

#include "solve/assembly/step_strains_impl.h"

namespace deform {

std::vector<double> mean_energies(const TupleAssembler& term, const Strains& strains) {
  std::vector<double> energies = term.energies(strains.to_r);
  for (double& e : energies) e *= 0.5;
  return energies;
}

void add_forces_of_mean_strains(ModelTerms& terms, const StateGeometry& now, Strains* strains,
                                NodeVectors& f) {
  for (std::size_t i = 0; i < terms.sets().size(); ++i) {
    JetAssembler& assembler = terms.sets()[i].assembler;
    for (const JetAssembler::Term& term : assembler.terms()) {
      if (!term.traits.strains) continue;
      assembler.evaluate(terms.geometries(i, now, strains), JetAssembler::Part::stress, &term);
      assembler.add_force(f);
    }
  }
  terms.evaluate_tuples(now.r, strains);
  for (const TupleAssembler& t : terms.tuples())
    if (t.averages()) t.add_force(f);
}

void add_gradient_of_mean_energy(ModelTerms& terms, Strains* strains, NodeVectors& f) {
  NodeVectors gradient = NodeVectors::Zero(f.rows(), 3);
  for (std::size_t i = 0; i < terms.sets().size(); ++i) {
    SetTerms& set = terms.sets()[i];
    Geometry& to = strains->to[i];
    if (!to.has_mean_strains()) to.average_forms(strains->from[i]);
    for (const JetAssembler::Term& term : set.assembler.terms()) {
      if (!term.traits.strains) continue;
      set.assembler.evaluate({to, to, set.rest}, JetAssembler::Part::stress, &term);
      set.assembler.add_force(gradient);
    }
  }
  for (TupleAssembler& t : terms.tuples()) {
    if (!t.averages()) continue;
    t.evaluate(strains->to_r, strains->to_r);
    t.add_force(gradient);
  }
  f -= gradient;
}

}  // namespace deform
