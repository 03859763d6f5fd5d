/// The part of a System that takes energy away: damping per area, of materials, of force fields.
#include <algorithm>

#include "solve/stopwatch.h"
#include "solve/system_impl.h"

namespace deform {

bool System::Impl::has_material_damping() const {
  return std::ranges::any_of(parts.retardation, [](double t) { return t > 0; });
}

std::vector<double> System::Impl::damping_factors(bool of_strains) const {
  std::vector<double> factors(parts.energies.size(), 0.0);
  for (std::size_t t = 0; t < factors.size() && t < parts.retardation.size(); ++t)
    if ((strain_rate > 0 && traits[t].strains) == of_strains)
      factors[t] = parts.retardation[t] * (of_strains ? strain_rate : 1);
  return factors;
}

/// D = Σ_t θ_t K_t with the Gauss–Newton tangent of each term at r: for a quadratic energy
/// ½ C (T − T⁰)² the force −D v is that of the stress θ C Ṫ. It resists strain rates as the term
/// resists strains, and rigid motions not at all; its power −vᵀDv is never positive.
void System::Impl::update_damping(const NodeVectors& r) {
  if (damped_at.rows() == r.rows() && damped_at == r) return;
  const Stopwatch watch(times.assembly, "tangent of damping");
  if (tangent.nodes == 0) make_tangent_pattern();
  if (damping.nodes == 0) {
    damping = tangent;
    damping.value.resize(9 * damping.column.size());
  }
  const std::vector<double> factors = damping_factors(false);
  if (averages_strains) update_geometry(r);
  const auto of = [&](SetPart& set) -> Geometries {
    if (averages_strains) return geometries(set);
    if (set.damped.size() == 0) set.damped = Geometry(set.assembler.samples());
    set.compute(set.damped, r);
    return {set.damped, set.damped, set.rest};
  };
  tangents.assemble({geometries_of_sets(of), Tangent::gauss_newton, factors}, damping);
  for (TupleAssembler& t : tuples)
    t.add_tangent(r, Tangent::gauss_newton, damping, factors[t.number()]);
  damped_at = r;
}

/// θ/τ times the term's own force, strains being those since the step began.
void System::Impl::add_strain_damping(NodeVectors& f) {
  const std::vector<double> factors = damping_factors(true);
  for (SetPart& set : sets)
    for (const JetAssembler::Term& term : set.assembler.terms()) {
      if (factors[term.number] == 0) continue;
      NodeVectors alone = NodeVectors::Zero(f.rows(), 3);
      set.assembler.evaluate(since_begun(set), JetAssembler::Part::stress, &term);
      set.assembler.add_force(alone);
      f += factors[term.number] * alone;
    }
}

void System::Impl::add_strain_damping_tangent(Tangent kind, BlockMatrix& sum) {
  const std::vector<double> factors = damping_factors(true);
  tangents.assemble({geometries_of_sets([&](SetPart& set) { return since_begun(set); }),
                     kind == Tangent::foreseen ? Tangent::exact : kind, factors},
                    sum, true);
}

void System::Impl::add_material_damping(const State& state, NodeVectors& f) {
  if (!has_material_damping()) return;
  if (strain_rate > 0) add_strain_damping(f);
  const std::vector<double> factors = damping_factors(false);
  const bool has_other = std::ranges::any_of(factors, [](double t) { return t > 0; });
  if (!has_other || state.v.isZero(0)) return;
  update_damping(state.r);
  NodeVectors resisted;
  damping.multiply(state.v, resisted);
  f -= resisted;
}

void System::measure_strains_from(double rate, const NodeVectors& r, double s,
                                  const NodeVectors& earlier) {
  if (!impl_->has_material_damping()) return;
  impl_->strain_rate = rate;
  impl_->damped_at.resize(0, 3);  // the other terms' part of it changes, too
  if (rate == 0) return;
  for (SetPart& set : impl_->sets) {
    if (set.begun.size() == 0) set.begun = set.earlier = Geometry(set.assembler.samples());
    set.compute(set.begun, r);
    if (s == 0) continue;
    set.compute(set.earlier, earlier);
    set.begun.blend(s, set.earlier);
  }
}

double System::damping_potential(const State& state) {
  if (impl_->strain_rate == 0) return 0;
  impl_->update_geometry(state.r);
  const std::vector<double> factors = impl_->damping_factors(true);
  double sum = 0;
  for (SetPart& set : impl_->sets)
    for (const JetAssembler::Term& term : set.assembler.terms()) {
      if (factors[term.number] == 0) continue;
      std::vector<double> density(static_cast<std::size_t>(set.assembler.samples().size()));
      set.assembler.energy_density(term, impl_->since_begun(set), density);
      const ConstValues weights = set.assembler.samples().weights();
      for (std::size_t i = 0; i < density.size(); ++i)
        sum += factors[term.number] * weights[i] * density[i];
    }
  return sum;
}

bool System::has_force_beside_potential() const {
  if (impl_->averages_strains && impl_->knows_strains()) return true;
  if (!impl_->external.without_potential().empty()) return true;
  if (!impl_->has_material_damping()) return false;
  const std::vector<double> factors = impl_->damping_factors(false);
  return std::ranges::any_of(factors, [](double t) { return t > 0; });
}

NodeVectors System::force_beside_potential(const State& state) {
  impl_->update_geometry(state.r);
  NodeVectors f = NodeVectors::Zero(nodes(), 3);
  const std::vector<std::string> names = impl_->external.without_potential();
  for (const Named<ForceField>& field : impl_->external.fields())
    if (std::ranges::find(names, field.name) != names.end()) f += impl_->force_of(field, state);
  impl_->add_material_damping(state, f);
  if (impl_->strain_rate > 0) {  // that has a potential of its own
    NodeVectors of_strains = NodeVectors::Zero(nodes(), 3);
    impl_->add_strain_damping(of_strains);
    f -= of_strains;
  }
  if (impl_->averages_strains) {
    impl_->add_strain_forces(f);
    impl_->add_gradient_of_mean_energy(f);
  }
  return f;
}

NodeVectors System::damping_force(const State& state) {
  NodeVectors f(nodes(), 3);
  for (int c = 0; c < 3; ++c) f.col(c) = -impl_->parts.damping.cwiseProduct(state.v.col(c));
  impl_->add_material_damping(state, f);
  return f;
}

}  // namespace deform
