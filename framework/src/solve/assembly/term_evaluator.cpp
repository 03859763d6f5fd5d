#include "deform/solve/term_evaluator.h"

#include "solve/assembly/assembly.h"
#include "solve/assembly/part_forces.h"
#include "solve/assembly/term_energy.h"

namespace deform {

std::shared_ptr<const Geometry> TermEvaluator::geometry(const NodeVectors& r,
                                                        const SampleSet& samples) const {
  return assembly_->terms.complete_geometry(r, samples);
}

const Geometry& TermEvaluator::rest_geometry(const SampleSet& samples) const {
  return assembly_->terms.sets()[assembly_->terms.set_of(samples)].rest;
}

double TermEvaluator::energy(std::size_t term, const State& state) const {
  return term_energy(assembly_->terms, term, state.r, nullptr);
}

std::vector<double> TermEvaluator::energy_density(std::size_t term, const NodeVectors& r) const {
  std::vector<double> density;
  find_energy_density(assembly_->terms, term, *assembly_->terms.geometry_at(r), nullptr, density);
  return density;
}

double TermEvaluator::external_potential(const State& state) const {
  return deform::external_potential(assembly_->terms, state);
}

NodeVectors TermEvaluator::internal_force(std::size_t term, const State& state) const {
  return deform::internal_force(*assembly_, term, state);
}

NodeVectors TermEvaluator::external_force(const State& state) const {
  return deform::external_force(*assembly_, state);
}

TermEvaluator::LaggedForce TermEvaluator::lagged_force(std::size_t term, const State& state) const {
  LaggedForce result{{}, NodeVectors::Zero(assembly_->terms.rows(), 3)};
  deform::lagged_force(*assembly_, term, state, result.k, result.c);
  return result;
}

std::string TermEvaluator::largest_force_at(Index node, const State& state) const {
  return deform::largest_force_at(*assembly_, node, state);
}

std::vector<std::string> TermEvaluator::notes() const {
  std::vector<std::string> notes;
  for (const SetTerms& set : assembly_->terms.sets())
    for (const JetAssembler::Term& term : set.assembler.terms())
      if (set.assembler.is_numerical(term, {set.rest, set.rest, set.rest}))
        notes.push_back("the force of " + term.origin +
                        " is a numerical derivative of its energy density: it gives no stress");
  return notes;
}

}  // namespace deform
