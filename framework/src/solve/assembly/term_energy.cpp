#include "solve/assembly/term_energy.h"

#include <algorithm>
#include <cmath>

#include "not_finite.h"
#include "solve/assembly/averaged_strains.h"
#include "solve/assembly/step_strains_impl.h"

namespace deform {
namespace {

[[noreturn]] void throw_energy_not_finite(const ModelTerms& terms, std::size_t term, Index node) {
  const Named<EnergyTerm>& guilty = terms.energy(term);
  throw NotFinite("the energy of " + guilty.origin + " is not finite", node, guilty.name);
}

double tuple_energy(ModelTerms& terms, const TupleAssembler& tuples, const NodeVectors& r,
                    Strains* strains) {
  const bool is_mean = averages(strains) && tuples.averages();
  if (is_mean) strains->update_mean(*terms.geometry_at(r));
  const std::vector<double> energies =
      is_mean ? mean_energies(tuples, *strains) : tuples.energies(r);
  double sum = 0;
  for (std::size_t i = 0; i < energies.size(); ++i) {
    if (!std::isfinite(energies[i]))
      throw_energy_not_finite(terms, tuples.number(), tuples.first_node(i));
    sum += energies[i];
  }
  return sum;
}

}  // namespace

double term_energy(ModelTerms& terms, std::size_t term, const NodeVectors& r, Strains* strains) {
  terms.meter().require_going_on();
  for (const TupleAssembler& t : terms.tuples())
    if (t.number() == term) return tuple_energy(terms, t, r, strains);
  const auto now = terms.geometry_at(r);
  if (averages(strains)) strains->update_mean(*now);
  std::vector<double>& density = terms.room_for_density();
  find_energy_density(terms, term, *now, strains, density);
  for (const SetTerms& set : terms.sets())
    if (set.assembler.find(term) != nullptr) {
      const ConstValues weights = set.assembler.samples().weights();
      double sum = 0;
      for (std::size_t s = 0; s < density.size(); ++s) sum += weights[s] * density[s];
      return sum;
    }
  return 0;
}

void find_energy_density(ModelTerms& terms, std::size_t term, const StateGeometry& now,
                         Strains* strains, std::vector<double>& density) {
  density.clear();
  for (std::size_t i = 0; i < terms.sets().size(); ++i) {
    const JetAssembler& assembler = terms.sets()[i].assembler;
    const auto* t = assembler.find(term);
    if (t == nullptr) continue;
    density.resize(static_cast<std::size_t>(assembler.samples().size()));
    assembler.energy_density(*t, terms.geometries(i, now, strains), density);
    const auto bad = std::ranges::find_if_not(density, [](double e) { return std::isfinite(e); });
    if (bad != density.end())
      throw_energy_not_finite(terms, term,
                              assembler.samples().stencil(bad - density.begin()).nodes.front());
    return;
  }
}

double external_potential(ModelTerms& terms, const State& state) {
  const auto now = terms.geometry_at(state.r);
  ExternalForces& external = terms.external();
  double sum = 0;
  for (const double e : external.potential(state, now->normals)) sum += e;
  if (std::isfinite(sum)) return sum;
  for (const auto& field : external.fields())
    require_finite(external.potential(state, now->normals, &field), "the potential energy",
                   field.origin, field.name);
  throw NotFinite("the sum of all potential energies is not finite", -1, "external forces");
}

}  // namespace deform
