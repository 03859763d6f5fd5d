#include "solve/assembly/model_terms.h"

#include <algorithm>
#include <utility>

#include "plugin/guard.h"
#include "solve/assembly/pattern.h"
#include "solve/assembly/step_strains_impl.h"
#include "solve/assembly/tangent_assembler.h"
#include "solve/stopwatch.h"

namespace deform {

ModelTerms::ModelTerms(const ModelParts& parts, WorkMeter& meter)
    : parts_(&parts), meter_(&meter), external_(parts) {
  read_traits();
  make_sets();
  make_tuples();
  make_lagged_pattern();
  for (SetTerms& set : sets_) set.rest.compute(set.assembler.samples(), parts.rest);
}

void ModelTerms::read_traits() {
  for (const auto& e : parts_->energies) {
    if (!std::dynamic_pointer_cast<const JetTerm>(e.object) &&
        !std::dynamic_pointer_cast<const TupleTerm>(e.object))
      throw PluginFailure("plugin " + e.origin +
                          " made an energy term that is neither a JetTerm nor a TupleTerm");
    traits_.push_back(guarded(e.origin, "saying what it is", [&] { return e.object->traits(); }));
  }
}

SampleRole ModelTerms::role_of(std::size_t term, const JetTerm& jet) const {
  const SampleRole role =
      guarded(energy(term).origin, "saying where it lives", [&] { return jet.role(); });
  if (role != SampleRole::membrane && role != SampleRole::bending)
    throw PluginFailure("plugin " + energy(term).origin + " lives on a sample set that is none");
  return role;
}

void ModelTerms::make_sets() {
  // Probes and outputs look at both roles' sets, whether a term lives there or not.
  std::vector<const SampleSet*> all;
  for (const SampleRole role : {SampleRole::membrane, SampleRole::bending}) {
    const SampleSet* set = &parts_->surface->samples(role);
    if (std::ranges::find(all, set) == all.end()) all.push_back(set);
  }
  for (const SampleSet* set : all) {
    std::vector<JetAssembler::Term> terms;
    for (std::size_t t = 0; t < parts_->energies.size(); ++t)
      if (const auto jet = std::dynamic_pointer_cast<const JetTerm>(energy(t).object))
        if (&parts_->surface->samples(role_of(t, *jet)) == set)
          terms.push_back({t, energy(t).origin, jet, traits_[t]});
    JetAssembler assembler(*set, std::move(terms));
    const Geometry::Detail detail = std::max(assembler.detail(), detail_of_normals(*set));
    sets_.push_back({.assembler = std::move(assembler), .detail = detail, .rest = Geometry(*set)});
  }
}

/// What forces along normals need of a set.
Geometry::Detail ModelTerms::detail_of_normals(const SampleSet& set) const {
  const bool is_needed =
      external_.needs_normals() && &parts_->surface->samples(SampleRole::bending) == &set;
  return is_needed ? Geometry::Detail::first : Geometry::Detail::none;
}

/// Of the terms before this one.
Index ModelTerms::scalars_before(std::size_t number) const {
  Index count = 0;
  for (const TupleAssembler& t : tuples_)
    if (t.number() < number) count += t.scalars();
  return count;
}

void ModelTerms::make_tuples() {
  const Index shared = nodes() + std::ssize(parts_->surface->scalars());
  for (std::size_t t = 0; t < parts_->energies.size(); ++t)
    if (const auto term = std::dynamic_pointer_cast<const TupleTerm>(energy(t).object))
      tuples_.emplace_back(t, energy(t).origin, term, traits_[t],
                           TupleAssembler::Rows{nodes(), shared, rows(), scalars_before(t)});
}

void ModelTerms::make_lagged_pattern() {
  PatternBuilder pattern(rows());
  const auto add = [&](Index a, Index b) { pattern.add(a, b); };
  for (const SetTerms& set : sets_) set.assembler.visit_pattern(add);
  for (const TupleAssembler& t : tuples_) t.visit_pattern(add);
  lagged_pattern_ = pattern.build();
  for (SetTerms& set : sets_) set.assembler.bind(lagged_pattern_);
  for (TupleAssembler& t : tuples_) t.bind(lagged_pattern_);
}

bool ModelTerms::know_strains() const {
  return std::ranges::any_of(traits_, [](const TermTraits& t) { return t.strains; }) ||
         std::ranges::any_of(tuples_, [](const TupleAssembler& t) { return t.averages(); });
}

bool ModelTerms::have_tangents() const {
  const auto have = [](const SetTerms& set) {
    return std::ranges::all_of(set.assembler.terms(), TangentAssembler::has_tangent);
  };
  return std::ranges::all_of(sets_, have) &&
         std::ranges::all_of(tuples_, [](const TupleAssembler& t) { return t.has_potential(); });
}

std::size_t ModelTerms::set_of(const SampleSet& samples) const {
  for (std::size_t i = 0; i < sets_.size(); ++i)
    if (&sets_[i].assembler.samples() == &samples) return i;
  throw Error(ExitCode::internal_error, "a sample set that is not the surface's");
}

/// A place for another state's geometry.
std::shared_ptr<StateGeometry> ModelTerms::room() {
  std::shared_ptr<StateGeometry> geometry = cache_.room();
  if (geometry->of_set.empty()) {
    for (const SetTerms& set : sets_) geometry->of_set.emplace_back(set.assembler.samples());
    geometry->normals = NodeVectors::Zero(nodes(), 3);
  }
  return geometry;
}

/// What is computed of r at all sets is what the cache has of it.
void ModelTerms::keep(const std::shared_ptr<StateGeometry>& geometry, const NodeVectors& r) {
  if (external_.needs_normals()) {
    const std::size_t bending = set_of(parts_->surface->samples(SampleRole::bending));
    sets_[bending].assembler.node_normals(geometry->of_set[bending], geometry->normals);
  }
  cache_.keep(geometry, r);
}

std::shared_ptr<StateGeometry> ModelTerms::known_or_new(const NodeVectors& r) {
  if (std::shared_ptr<StateGeometry> known = cache_.find(r)) return known;
  const Stopwatch watch(&StepTimes::geometry, "geometry");
  std::shared_ptr<StateGeometry> geometry = room();
  for (std::size_t i = 0; i < sets_.size(); ++i) sets_[i].compute(geometry->of_set[i], r);
  keep(geometry, r);
  return geometry;
}

std::shared_ptr<const StateGeometry> ModelTerms::geometry_at(const NodeVectors& r) {
  return known_or_new(r);
}

std::shared_ptr<const Geometry> ModelTerms::complete_geometry(const NodeVectors& r,
                                                              const SampleSet& samples) {
  const std::shared_ptr<StateGeometry> at = known_or_new(r);
  Geometry& geometry = at->of_set[set_of(samples)];
  geometry.complete(samples, at->r);
  return {at, &geometry};
}

Geometries ModelTerms::geometries(std::size_t i, const StateGeometry& now, Strains* strains) const {
  const Geometry& of_set = now.of_set[i];
  return {of_set, of_set, sets_[i].rest, nullptr, averages(strains) ? &strains->mean[i] : nullptr};
}

/// Stress of a block of samples follows their geometry while that is in cache.
std::shared_ptr<const StateGeometry> ModelTerms::evaluate(const NodeVectors& r, Strains* strains,
                                                          JetAssembler::Part part) {
  std::shared_ptr<StateGeometry> now = averages(strains) ? known_or_new(r) : cache_.find(r);
  if (now) {
    if (averages(strains)) strains->update_mean(*now);
    for (std::size_t i = 0; i < sets_.size(); ++i)
      sets_[i].assembler.evaluate(geometries(i, *now, strains), part);
    return now;
  }
  now = room();
  for (std::size_t i = 0; i < sets_.size(); ++i) {
    SetTerms& set = sets_[i];
    // One reference for all: what a std::function keeps without an allocation.
    const struct {
      Geometry& now;
      const SampleSet& samples;
      const NodeVectors& r;
    } of{now->of_set[i], set.assembler.samples(), r};
    const Geometries all{of.now, of.now, set.rest};
    if (set.assembler.evaluates_by_blocks()) {
      of.now.begin(set.detail);
      set.assembler.evaluate(all, part, nullptr, [&of](Index first, Index size) {
        of.now.compute(of.samples, of.r, first, size);
      });
    } else {
      set.compute(of.now, r);
      set.assembler.evaluate(all, part);
    }
  }
  keep(now, r);
  return now;
}

void ModelTerms::evaluate_tuples(const NodeVectors& r, Strains* strains) {
  for (std::size_t i = 0; i < tuples_.size(); ++i) {
    TupleAssembler& t = tuples_[i];
    if (averages(strains) && t.averages())
      t.evaluate_over_step(strains->from_r, r, strains->to_r, strains->tuple_energies[i]);
    else
      t.evaluate(r, r);
  }
}

void ModelTerms::add_internal_force(NodeVectors& f) const {
  for (const SetTerms& set : sets_) set.assembler.add_force(f);
  for (const TupleAssembler& t : tuples_) t.add_force(f);
}

void ModelTerms::add_force_of(std::size_t term, const StateGeometry& now, Strains* strains,
                              NodeVectors& f) {
  for (std::size_t i = 0; i < sets_.size(); ++i)
    if (const auto* t = sets_[i].assembler.find(term)) {
      sets_[i].assembler.evaluate(geometries(i, now, strains), JetAssembler::Part::stress, t);
      sets_[i].assembler.add_force(f);
    }
  for (std::size_t i = 0; i < tuples_.size(); ++i)
    if (tuples_[i].number() == term) {
      tuples_[i].evaluate(now.r, now.r);
      tuples_[i].add_force(f);
    }
}

NodeVectors ModelTerms::force_of(const Named<ForceField>& field, const State& state,
                                 const StateGeometry& now) {
  NodeVectors f = NodeVectors::Zero(state.r.rows(), 3);
  external_.add_force(state, now.normals, f, &field);
  return f;
}

}  // namespace deform
