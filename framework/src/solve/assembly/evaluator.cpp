#include "deform/solve/evaluator.h"

#include <algorithm>

#include "profile/profile.h"
#include "solve/assembly/all_forces.h"
#include "solve/assembly/assembly.h"
#include "solve/assembly/averaged_strains.h"
#include "solve/assembly/part_forces.h"
#include "solve/assembly/step_strains_impl.h"
#include "solve/assembly/term_energy.h"
#include "solve/stopwatch.h"

namespace deform {

void Evaluator::force(const State& state, NodeVectors& f, const StepStrains* strains) const {
  Assembly& a = *assembly_;
  Strains* const over_step = impl_of(strains);
  sum_all_forces(a, state, over_step, JetAssembler::Part::stress, f);
  if (!f.allFinite()) throw_force_not_finite(a, state, f);
}

double Evaluator::potential(const State& state, const StepStrains* strains) const {
  const Span span("potential");
  double sum = external_potential(assembly_->terms, state);
  for (std::size_t t = 0; t < assembly_->terms.traits().size(); ++t)
    sum += term_energy(assembly_->terms, t, state.r, impl_of(strains));
  return sum;
}

double Evaluator::damping_potential(const State& state, const StepStrains& strains) const {
  Strains* const over_step = impl_of(&strains);
  if (rate_of(over_step) == 0) return 0;
  return assembly_->damping.step_potential(*assembly_->terms.geometry_at(state.r), over_step);
}

bool Evaluator::has_nonconservative_force(const StepStrains* strains) const {
  Strains* const over_step = impl_of(strains);
  if (averages(over_step) && assembly_->terms.know_strains()) return true;
  if (!assembly_->terms.external().without_potential().empty()) return true;
  return assembly_->damping.is_any_by_velocity(over_step);
}

NodeVectors Evaluator::nonconservative_force(const State& state, const StepStrains* strains) const {
  ModelTerms& terms = assembly_->terms;
  Strains* const over_step = impl_of(strains);
  const auto now = terms.geometry_at(state.r);
  if (averages(over_step)) over_step->update_mean(*now);
  NodeVectors f = NodeVectors::Zero(state.r.rows(), 3);
  const std::vector<std::string> names = terms.external().without_potential();
  for (const Named<ForceField>& field : terms.external().fields())
    if (std::ranges::find(names, field.name) != names.end())
      f += terms.force_of(field, state, *now);
  assembly_->damping.add_force(state, *now, over_step, f);
  if (rate_of(over_step) > 0) {  // that has a potential of its own
    NodeVectors of_strains = NodeVectors::Zero(state.r.rows(), 3);
    assembly_->damping.add_step_force(*now, over_step, of_strains);
    f -= of_strains;
  }
  if (averages(over_step)) {
    add_forces_of_mean_strains(terms, *now, over_step, f);
    add_gradient_of_mean_energy(terms, over_step, f);
  }
  return f;
}

NodeVectors Evaluator::damping_force(const State& state) const {
  const NodeValues& damping = assembly_->terms.parts().damping;
  NodeVectors f(state.r.rows(), 3);
  for (int c = 0; c < 3; ++c) f.col(c) = -damping.cwiseProduct(state.v.col(c));
  if (assembly_->damping.is_any())
    assembly_->damping.add_force(state, *assembly_->terms.geometry_at(state.r), nullptr, f);
  return f;
}

std::vector<std::string> Evaluator::without_potential() const {
  std::vector<std::string> names = assembly_->terms.external().without_potential();
  for (std::size_t t = 0; t < assembly_->terms.traits().size(); ++t)
    if (!assembly_->terms.traits()[t].potential) names.push_back(assembly_->terms.energy(t).name);
  return names;
}

std::vector<std::string> Evaluator::without_tangent() const {
  std::vector<std::string> names = assembly_->terms.external().without_tangent();
  for (std::size_t t = 0; t < assembly_->terms.traits().size(); ++t)
    if (!assembly_->terms.traits()[t].potential) names.push_back(assembly_->terms.energy(t).name);
  return names;
}

bool Evaluator::energies_have_potential() const {
  return std::ranges::all_of(assembly_->terms.traits(),
                             [](const TermTraits& t) { return t.potential; });
}

}  // namespace deform
