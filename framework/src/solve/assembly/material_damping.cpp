#include "solve/assembly/material_damping.h"

#include <algorithm>

#include "solve/assembly/step_strains_impl.h"
#include "solve/stopwatch.h"

namespace deform {

bool MaterialDamping::is_any() const {
  return std::ranges::any_of(terms_->parts().retardation, [](double t) { return t > 0; });
}

bool MaterialDamping::is_any_by_velocity(Strains* strains) const {
  if (!is_any()) return false;
  const std::vector<double> of_velocity = factors(false, strains);
  return std::ranges::any_of(of_velocity, [](double t) { return t > 0; });
}

std::vector<double> MaterialDamping::factors(bool over_step, Strains* strains) const {
  const std::vector<double>& retardation = terms_->parts().retardation;
  std::vector<double> factors(terms_->parts().energies.size(), 0.0);
  const double rate = rate_of(strains);
  for (std::size_t t = 0; t < factors.size() && t < retardation.size(); ++t)
    if ((rate > 0 && terms_->traits()[t].strains) == over_step)
      factors[t] = retardation[t] * (over_step ? rate : 1);
  return factors;
}

Geometries MaterialDamping::since_begun(std::size_t set, const StateGeometry& now,
                                        Strains* strains) const {
  const Geometry& of_set = now.of_set[set];
  return {of_set, of_set, terms_->sets()[set].rest, &strains->begun[set]};
}

const BlockMatrix& MaterialDamping::matrix(const StateGeometry& now, Strains* strains) {
  const long version = strains == nullptr ? 0 : strains->version;
  if (at_.rows() == now.r.rows() && at_ == now.r && of_strains_ == version) return matrix_;
  const Stopwatch watch(&StepTimes::assembly, "tangent of damping");
  if (matrix_.nodes == 0) {
    matrix_ = tangents_->pattern();
    matrix_.value.resize(9 * matrix_.column.size());
  }
  const std::vector<double> of_velocity = factors(false, strains);
  const auto geometries = terms_->geometries_of_sets(
      [&](std::size_t i) { return terms_->geometries(i, now, strains); });
  tangents_->assemble({geometries, Tangent::gauss_newton, of_velocity}, matrix_);
  for (TupleAssembler& t : terms_->tuples())
    t.add_tangent(now.r, Tangent::gauss_newton, matrix_, of_velocity[t.number()]);
  at_ = now.r;
  of_strains_ = version;
  return matrix_;
}

void MaterialDamping::add_step_force(const StateGeometry& now, Strains* strains, NodeVectors& f) {
  if (!(rate_of(strains) > 0)) return;
  const std::vector<double> over_step = factors(true, strains);
  for (std::size_t i = 0; i < terms_->sets().size(); ++i) {
    JetAssembler& assembler = terms_->sets()[i].assembler;
    for (const JetAssembler::Term& term : assembler.terms()) {
      if (over_step[term.number] == 0) continue;
      NodeVectors alone = NodeVectors::Zero(f.rows(), 3);
      assembler.evaluate(since_begun(i, now, strains), JetAssembler::Part::stress, &term);
      assembler.add_force(alone);
      f += over_step[term.number] * alone;
    }
  }
}

void MaterialDamping::add_force(const State& state, const StateGeometry& now, Strains* strains,
                                NodeVectors& f) {
  if (!is_any()) return;
  add_step_force(now, strains, f);
  if (!is_any_by_velocity(strains) || state.v.isZero(0)) return;
  NodeVectors resisted;
  matrix(now, strains).multiply(state.v, resisted);
  f -= resisted;
}

double MaterialDamping::step_potential(const StateGeometry& now, Strains* strains) {
  if (rate_of(strains) == 0) return 0;
  const std::vector<double> over_step = factors(true, strains);
  double sum = 0;
  for (std::size_t i = 0; i < terms_->sets().size(); ++i) {
    const JetAssembler& assembler = terms_->sets()[i].assembler;
    for (const JetAssembler::Term& term : assembler.terms()) {
      if (over_step[term.number] == 0) continue;
      std::vector<double> density(static_cast<std::size_t>(assembler.samples().size()));
      assembler.energy_density(term, since_begun(i, now, strains), density);
      const ConstValues weights = assembler.samples().weights();
      for (std::size_t s = 0; s < density.size(); ++s)
        sum += over_step[term.number] * weights[s] * density[s];
    }
  }
  return sum;
}

void MaterialDamping::add_tangent(const StateGeometry& now, Strains* strains, Tangent kind,
                                  double rate, BlockMatrix& k) {
  if (rate_of(strains) > 0) {
    const std::vector<double> over_step = factors(true, strains);
    const auto since =
        terms_->geometries_of_sets([&](std::size_t i) { return since_begun(i, now, strains); });
    tangents_->assemble({since, kind == Tangent::mixed ? Tangent::exact : kind, over_step}, k,
                        true);
  }
  if (rate == 0 || !is_any_by_velocity(strains)) return;
  const BlockMatrix& d = matrix(now, strains);
  for (std::size_t i = 0; i < k.value.size(); ++i) k.value[i] += rate * d.value[i];
}

}  // namespace deform
