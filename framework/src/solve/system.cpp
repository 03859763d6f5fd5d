#include "deform/solve/system.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "parallel/parallel.h"
#include "plugin/guard.h"
#include "solve/external_forces.h"
#include "solve/jet_assembler.h"
#include "solve/pattern.h"
#include "solve/reduced_solver.h"
#include "solve/stopwatch.h"
#include "solve/tuple_assembler.h"

namespace deform {

/// One sample set with its terms, and its geometry at the states that matter.
struct SetPart {
  JetAssembler assembler;
  Geometry rest;
  std::array<Geometry, 2> geometry;  // one of a step's start, one of any other state
};

struct System::Impl {
  explicit Impl(ModelParts p);

  void make_sets();
  void make_tuples();
  void make_pattern();
  [[nodiscard]] SetPart& set_of(const SampleSet& samples);
  [[nodiscard]] Geometries geometries(SetPart& set) {
    return {set.geometry[current], set.geometry[current], set.rest};
  }
  void update_geometry(const NodeVectors& r);
  void update_normals();
  void evaluate_internal(const State& state);
  void add_internal_force(NodeVectors& f) const;

  ModelParts parts;
  Reduction reduction;
  std::vector<SetPart> sets;
  std::vector<TupleAssembler> tuples;
  ExternalForces external;

  std::array<NodeVectors, 2> known;  // positions of geometry[0] and [1]
  std::size_t current = 0;           // which of both is that of the last updated state
  std::optional<std::size_t> held;   // which is that of the step's start
  NodeVectors normals;               // at the nodes, of the current geometry

  NodeVectors force;
  NodeValues force_stiffness, force_damping;
  SparseMatrix k;
  long version = 0;
  std::optional<ReducedSolver> solver;
  std::string no_solver = "none was needed";
  StepTimes times;
};

System::Impl::Impl(ModelParts p)
    : parts(std::move(p)), reduction(parts.surface->nodes()), external(parts) {
  const Index n = parts.surface->nodes();
  for (const auto& c : parts.constraints)
    guarded(c.origin, "saying what it holds", [&] { c.object->reduce(reduction); });
  force = NodeVectors::Zero(n, 3);
  normals = NodeVectors::Zero(n, 3);
  force_stiffness = force_damping = NodeValues::Zero(n);
  make_sets();
  make_tuples();
  make_pattern();
  for (SetPart& set : sets) set.rest.compute(set.assembler.samples(), parts.rest);
}

void System::Impl::make_sets() {
  // Probes and outputs look at both roles' sets, whether a term lives there or not.
  std::vector<const SampleSet*> all;
  for (const SampleRole role : {SampleRole::membrane, SampleRole::bending}) {
    const SampleSet* set = &parts.surface->samples(role);
    if (std::ranges::find(all, set) == all.end()) all.push_back(set);
  }
  for (const SampleSet* set : all) {
    std::vector<JetAssembler::Term> terms;
    for (std::size_t t = 0; t < parts.energies.size(); ++t)
      if (const auto jet = std::dynamic_pointer_cast<const JetTerm>(parts.energies[t].object))
        if (&parts.surface->samples(jet->role()) == set)
          terms.push_back({t, parts.energies[t].origin, jet, jet->traits()});
    sets.push_back(
        {JetAssembler(*set, std::move(terms)), Geometry(*set), {Geometry(*set), Geometry(*set)}});
  }
}

void System::Impl::make_tuples() {
  for (std::size_t t = 0; t < parts.energies.size(); ++t)
    if (const auto term = std::dynamic_pointer_cast<const TupleTerm>(parts.energies[t].object))
      tuples.emplace_back(t, parts.energies[t].origin, term, parts.surface->nodes());
}

void System::Impl::make_pattern() {
  PatternBuilder pattern(parts.surface->nodes());
  const auto add = [&](Index a, Index b) { pattern.add(a, b); };
  for (const SetPart& set : sets) set.assembler.visit_pattern(add);
  for (const TupleAssembler& t : tuples) t.visit_pattern(add);
  k = pattern.build();
  for (SetPart& set : sets) set.assembler.bind(k);
  for (TupleAssembler& t : tuples) t.bind(k);
}

SetPart& System::Impl::set_of(const SampleSet& samples) {
  for (SetPart& set : sets)
    if (&set.assembler.samples() == &samples) return set;
  throw Error(ExitCode::internal_error, "a sample set that is not the surface's");
}

void System::Impl::update_geometry(const NodeVectors& r) {
  const auto is_known = [&](std::size_t i) { return known[i].rows() == r.rows() && known[i] == r; };
  if (is_known(current)) return;
  const Stopwatch watch(times.geometry);
  const std::size_t other = 1 - current;
  if (!is_known(other)) {
    // Never over the geometry of the step's start, which lagged probes read.
    const std::size_t place = held ? 1 - *held : current;
    for (SetPart& set : sets) set.geometry[place].compute(set.assembler.samples(), r);
    known[place] = r;
    current = place;
  } else {
    current = other;
  }
  if (external.needs_normals()) update_normals();
}

void System::Impl::update_normals() {
  SetPart& set = set_of(parts.surface->samples(SampleRole::bending));
  set.assembler.node_normals(set.geometry[current], normals);
}

void System::Impl::evaluate_internal(const State& state) {
  for (SetPart& set : sets) set.assembler.evaluate(geometries(set));
  for (TupleAssembler& t : tuples) t.evaluate(state.r, state.r);
}

void System::Impl::add_internal_force(NodeVectors& f) const {
  for (const SetPart& set : sets) set.assembler.add_force(f);
  for (const TupleAssembler& t : tuples) t.add_force(f);
}

System::System(ModelParts parts) : impl_(std::make_unique<Impl>(std::move(parts))) {}
System::~System() = default;

Index System::nodes() const { return impl_->parts.surface->nodes(); }
const Surface& System::surface() const { return *impl_->parts.surface; }
const NodeVectors& System::rest() const { return impl_->parts.rest; }
const NodeValues& System::mass() const { return impl_->parts.mass; }
const NodeValues& System::damping() const { return impl_->parts.damping; }
const Reduction& System::reduction() const { return impl_->reduction; }
const std::vector<Named<EnergyTerm>>& System::energies() const { return impl_->parts.energies; }
const NodeVectors& System::force() const { return impl_->force; }
const NodeValues& System::force_damping() const { return impl_->force_damping; }
const SparseMatrix& System::lagged_operator() const { return impl_->k; }
StepTimes& System::times() { return impl_->times; }
const std::string& System::solver_choice() const {
  return impl_->solver ? impl_->solver->choice() : impl_->no_solver;
}

void System::begin_step(const State& state) {
  impl_->update_geometry(state.r);
  impl_->held = impl_->current;
}
void System::update_geometry(const State& state) { impl_->update_geometry(state.r); }
const Geometry& System::geometry(const SampleSet& samples) const {
  return impl_->set_of(samples).geometry[impl_->current];
}
const Geometry& System::previous_geometry(const SampleSet& samples) const {
  return impl_->set_of(samples).geometry[impl_->held.value_or(impl_->current)];
}
const Geometry& System::rest_geometry(const SampleSet& samples) const {
  return impl_->set_of(samples).rest;
}

void System::evaluate(const State& state) {
  impl_->update_geometry(state.r);
  const Stopwatch watch(impl_->times.assembly);
  impl_->evaluate_internal(state);
  impl_->force.setZero();
  impl_->add_internal_force(impl_->force);
  impl_->external.add_force(state, impl_->normals, impl_->force);
}

void System::evaluate_with_operator(const State& state) {
  evaluate(state);
  const Stopwatch watch(impl_->times.assembly);
  std::ranges::fill(impl_->k.value, 0.0);
  for (const SetPart& set : impl_->sets) set.assembler.add_operator(impl_->k);
  for (const TupleAssembler& t : impl_->tuples) t.add_operator(impl_->k);
  impl_->force_stiffness.setZero();
  impl_->force_damping.setZero();
  impl_->external.add_tangent(state, impl_->normals, impl_->force_stiffness, impl_->force_damping);
  for (Index a = 0; a < nodes(); ++a) {
    const auto row = static_cast<std::size_t>(a);
    const auto begin = impl_->k.column.begin() + impl_->k.row_begin[row];
    const auto end = impl_->k.column.begin() + impl_->k.row_begin[row + 1];
    const auto at = std::lower_bound(begin, end, a) - impl_->k.column.begin();
    impl_->k.value[static_cast<std::size_t>(at)] += impl_->force_stiffness[a];
  }
  ++impl_->version;
}

void System::solve(const NodeValues& d, const NodeVectors& b, NodeVectors& x) {
  if (!impl_->solver) {
    bool symmetric = true;
    for (const auto& e : impl_->parts.energies)
      symmetric = symmetric && e.object->traits().lagged != Lagged::unsymmetric;
    impl_->solver.emplace(impl_->reduction, impl_->k, symmetric, impl_->parts.make_solvers);
  }
  impl_->solver->solve(impl_->k, impl_->version, d, b, x, impl_->times);
}

void System::prescribe(double time, NodeVectors& r) const {
  if (impl_->parts.constraints.empty()) return;
  // Constraints speak of the unmirrored world.
  if (impl_->parts.mirrored) r.col(2) *= -1;
  for (const auto& c : impl_->parts.constraints)
    guarded(c.origin, "prescribing positions", [&] { c.object->prescribe(time, r); });
  if (impl_->parts.mirrored) r.col(2) *= -1;
}

double System::energy(std::size_t term, const State& state) {
  for (const TupleAssembler& t : impl_->tuples)
    if (t.number() == term) return t.energy(state.r);
  impl_->update_geometry(state.r);
  const std::vector<double> density = energy_density(term);
  for (const SetPart& set : impl_->sets)
    if (set.assembler.find(term) != nullptr) {
      const ConstValues weights = set.assembler.samples().weights();
      double sum = 0;
      for (std::size_t s = 0; s < density.size(); ++s) sum += weights[s] * density[s];
      return sum;
    }
  return 0;
}

std::vector<double> System::energy_density(std::size_t term) const {
  for (SetPart& set : impl_->sets)
    if (const auto* t = set.assembler.find(term)) {
      std::vector<double> density(static_cast<std::size_t>(set.assembler.samples().size()));
      set.assembler.energy_density(*t, impl_->geometries(set), density);
      return density;
    }
  return {};
}

double System::external_potential(const State& state) {
  impl_->update_geometry(state.r);
  return impl_->external.potential(state, impl_->normals);
}

NodeVectors System::internal_force(std::size_t term, const State& state) {
  impl_->update_geometry(state.r);
  NodeVectors f = NodeVectors::Zero(nodes(), 3);
  for (SetPart& set : impl_->sets)
    if (const auto* t = set.assembler.find(term)) {
      set.assembler.evaluate(impl_->geometries(set), JetAssembler::Part::stress, t);
      set.assembler.add_force(f);
    }
  for (TupleAssembler& t : impl_->tuples)
    if (t.number() == term) {
      t.evaluate(state.r, state.r);
      t.add_force(f);
    }
  return f;
}

NodeVectors System::external_force(const State& state) {
  impl_->update_geometry(state.r);
  NodeVectors f = NodeVectors::Zero(nodes(), 3);
  impl_->external.add_force(state, impl_->normals, f);
  return f;
}

System::LaggedForce System::lagged_force(std::size_t term, const State& state) {
  impl_->update_geometry(state.r);
  LaggedForce result{impl_->k, NodeVectors::Zero(nodes(), 3)};
  std::ranges::fill(result.k.value, 0.0);
  for (SetPart& set : impl_->sets)
    if (const auto* t = set.assembler.find(term)) {
      set.assembler.evaluate(impl_->geometries(set), JetAssembler::Part::constant, t);
      set.assembler.add_force(result.c);
      set.assembler.add_operator(result.k);
    }
  for (TupleAssembler& t : impl_->tuples)
    if (t.number() == term) {
      t.evaluate(state.r, state.r, TupleAssembler::Part::constant);
      t.add_force(result.c);
      t.add_operator(result.k);
    }
  return result;
}

std::string System::largest_force_at(Index node, const State& state) {
  std::string name = "external forces";
  const Vec3 load = external_force(state).row(node);
  if (!load.allFinite()) return name;
  double largest = load.norm();
  for (std::size_t t = 0; t < impl_->parts.energies.size(); ++t) {
    const Vec3 f = internal_force(t, state).row(node);
    if (!f.allFinite()) return impl_->parts.energies[t].name;
    if (f.norm() > largest) {
      largest = f.norm();
      name = impl_->parts.energies[t].name;
    }
  }
  return name;
}

}  // namespace deform
