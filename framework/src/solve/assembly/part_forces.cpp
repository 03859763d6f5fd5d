#include "solve/assembly/part_forces.h"

#include <algorithm>
#include <cstdint>

#include "not_finite.h"

namespace deform {

NodeVectors internal_force(Assembly& assembly, std::size_t term, const State& state) {
  ModelTerms& terms = assembly.terms;
  NodeVectors f = NodeVectors::Zero(state.r.rows(), 3);
  terms.add_force_of(term, *terms.geometry_at(state.r), nullptr, f);
  const Named<EnergyTerm>& energy = terms.energy(term);
  require_finite(f, "the force", energy.origin, energy.name);
  return f;
}

NodeVectors external_force(Assembly& assembly, const State& state) {
  ModelTerms& terms = assembly.terms;
  const auto now = terms.geometry_at(state.r);
  NodeVectors f = NodeVectors::Zero(state.r.rows(), 3);
  terms.external().add_force(state, now->normals, f);
  if (f.allFinite()) return f;
  for (const auto& field : terms.external().fields())
    require_finite(terms.force_of(field, state, *now), "the force", field.origin, field.name);
  throw NotFinite("the sum of all external forces is not finite", first_not_finite(f),
                  "external forces");
}

void lagged_force(Assembly& assembly, std::size_t term, const State& state, SparseMatrix& k,
                  NodeVectors& c) {
  ModelTerms& terms = assembly.terms;
  terms.meter().require_going_on();
  const auto now = terms.geometry_at(state.r);
  k = terms.lagged_pattern();
  std::ranges::fill(k.value, 0.0);
  for (std::size_t i = 0; i < terms.sets().size(); ++i) {
    JetAssembler& assembler = terms.sets()[i].assembler;
    const auto* t = assembler.find(term);
    if (t == nullptr) continue;
    assembler.evaluate(terms.geometries(i, *now, nullptr),
                       JetAssembler::Part::couplings_and_constant, t);
    assembler.add_force(c);
    assembler.add_operator(k);
  }
  for (TupleAssembler& t : terms.tuples())
    if (t.number() == term) {
      t.evaluate(state.r, state.r, TupleAssembler::Part::constant);
      t.add_force(c);
      t.add_operator(k);
    }
}

std::string largest_force_at(Assembly& assembly, Index node, const State& state) {
  ModelTerms& terms = assembly.terms;
  const auto now = terms.geometry_at(state.r);
  std::string name = "no force";
  double largest = 0;
  const auto compare = [&](const NodeVectors& f, const std::string& of) {
    const double norm = f.row(node).norm();
    if (norm > largest) largest = norm, name = of;
  };
  for (const auto& field : terms.external().fields())
    compare(terms.force_of(field, state, *now), field.name);
  for (std::size_t t = 0; t < terms.traits().size(); ++t)
    compare(internal_force(assembly, t, state), terms.energy(t).name);
  return name;
}

void throw_force_not_finite(Assembly& assembly, const State& state, const NodeVectors& force) {
  const Index node = first_not_finite(force);
  (void)external_force(assembly, state);  // each part by itself: the guilty one throws
  for (std::size_t t = 0; t < assembly.terms.traits().size(); ++t)
    (void)internal_force(assembly, t, state);
  throw NotFinite("the sum of all forces is not finite", node,
                  largest_force_at(assembly, node, state));
}

void throw_lagged_not_finite(Assembly& assembly, const State& state) {
  ModelTerms& terms = assembly.terms;
  const auto now = terms.geometry_at(state.r);
  for (const auto& field : terms.external().fields()) {
    NodeValues stiffness = NodeValues::Zero(terms.rows()), damping = stiffness;
    terms.external().add_tangent(state, now->normals, stiffness, damping, &field);
    require_finite(stiffness + damping, "the tangent", field.origin, field.name);
  }
  SparseMatrix k;
  NodeVectors c = NodeVectors::Zero(terms.rows(), 3);
  for (std::size_t t = 0; t < terms.traits().size(); ++t) {
    lagged_force(assembly, t, state, k, c);
    NodeValues sums = NodeValues::Zero(terms.rows());
    for (Index a = 0; a < terms.rows(); ++a)
      for (std::int32_t p = k.row_begin[static_cast<std::size_t>(a)];
           p < k.row_begin[static_cast<std::size_t>(a) + 1]; ++p)
        sums[a] += k.value[static_cast<std::size_t>(p)];
    const Named<EnergyTerm>& term = terms.energy(t);
    require_finite(sums, "the lagged operator", term.origin, term.name);
  }
  throw NotFinite("the sum of all lagged operators is not finite", -1, "lagged operator");
}

}  // namespace deform
