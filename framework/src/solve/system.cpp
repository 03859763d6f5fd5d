#include "deform/solve/system.h"

#include <algorithm>
#include <cmath>

#include "deform/parallel.h"

#include "not_finite.h"
#include "plugin/guard.h"
#include "solve/pattern.h"
#include "solve/stopwatch.h"
#include "solve/symmetry.h"
#include "solve/system_impl.h"

namespace deform {

System::Impl::Impl(ModelParts p) : parts(std::move(p)), external(parts) {
  Reduction reduction(parts.surface->nodes());
  const Index n = parts.surface->nodes();
  for (const auto& c : parts.constraints)
    guarded(c.origin, "saying what it holds", [&] { c.object->reduce(reduction); });
  map.emplace(reduction);
  contacts.emplace(parts.bodies, *map);
  force = NodeVectors::Zero(n, 3);
  normals = NodeVectors::Zero(n, 3);
  force_stiffness = force_damping = NodeValues::Zero(n);
  read_traits();
  make_sets();
  make_tuples();
  make_pattern();
  for (SetPart& set : sets) set.rest.compute(set.assembler.samples(), parts.rest);
}

void System::Impl::read_traits() {
  for (const auto& e : parts.energies) {
    if (!std::dynamic_pointer_cast<const JetTerm>(e.object) &&
        !std::dynamic_pointer_cast<const TupleTerm>(e.object))
      throw PluginFailure("plugin " + e.origin +
                          " made an energy term that is neither a JetTerm nor a TupleTerm");
    traits.push_back(guarded(e.origin, "saying what it is", [&] { return e.object->traits(); }));
  }
}

SampleRole System::Impl::role_of(std::size_t term, const JetTerm& jet) const {
  const SampleRole role =
      guarded(parts.energies[term].origin, "saying where it lives", [&] { return jet.role(); });
  if (role != SampleRole::membrane && role != SampleRole::bending)
    throw PluginFailure("plugin " + parts.energies[term].origin +
                        " lives on a sample set that is none");
  return role;
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
        if (&parts.surface->samples(role_of(t, *jet)) == set)
          terms.push_back({t, parts.energies[t].origin, jet, traits[t]});
    JetAssembler assembler(*set, std::move(terms));
    const Geometry::Detail detail = std::max(assembler.detail(), detail_of_normals(*set));
    sets.push_back({.assembler = std::move(assembler),
                    .detail = detail,
                    .rest = Geometry(*set),
                    .geometry = {Geometry(*set), Geometry(*set)}});
  }
}

/// What forces along normals need of a set.
Geometry::Detail System::Impl::detail_of_normals(const SampleSet& set) const {
  const bool is_needed =
      external.needs_normals() && &parts.surface->samples(SampleRole::bending) == &set;
  return is_needed ? Geometry::Detail::first : Geometry::Detail::none;
}

void System::Impl::make_tuples() {
  for (std::size_t t = 0; t < parts.energies.size(); ++t)
    if (const auto term = std::dynamic_pointer_cast<const TupleTerm>(parts.energies[t].object))
      tuples.emplace_back(t, parts.energies[t].origin, term, traits[t], parts.surface->nodes());
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

void System::Impl::update_normals() {
  SetPart& set = set_of(parts.surface->samples(SampleRole::bending));
  set.assembler.node_normals(set.geometry[current], normals);
}

void System::Impl::add_internal_force(NodeVectors& f) const {
  for (const SetPart& set : sets) set.assembler.add_force(f);
  for (const TupleAssembler& t : tuples) t.add_force(f);
}

NodeVectors System::Impl::force_of(const Named<ForceField>& field, const State& state) {
  NodeVectors f = NodeVectors::Zero(state.r.rows(), 3);
  external.add_force(state, normals, f, &field);
  return f;
}

bool System::Impl::operator_is_finite() const {
  const Eigen::Map<const Eigen::VectorXd> values(k.value.data(),
                                                 static_cast<Index>(k.value.size()));
  return values.allFinite() && force_stiffness.allFinite() && force_damping.allFinite();
}

System::System(ModelParts parts) : impl_(std::make_unique<Impl>(std::move(parts))) {}
System::~System() = default;

Index System::nodes() const { return impl_->parts.surface->nodes(); }
const Surface& System::surface() const { return *impl_->parts.surface; }
const NodeVectors& System::rest() const { return impl_->parts.rest; }
const NodeValues& System::areas() const { return impl_->parts.areas; }
const NodeValues& System::mass() const { return impl_->parts.mass; }
const NodeValues& System::damping() const { return impl_->parts.damping; }
const Reduction& System::reduction() const { return impl_->map->reduction(); }
const std::vector<Named<EnergyTerm>>& System::energies() const { return impl_->parts.energies; }
const NodeVectors& System::force() const { return impl_->force; }
const NodeValues& System::force_damping() const { return impl_->force_damping; }
const SparseMatrix& System::lagged_operator() const { return impl_->k; }
void System::stop_when(const std::atomic<bool>* stop) { impl_->stop = stop; }
StepTimes& System::times() { return impl_->times; }
StepReport& System::step_report() { return impl_->report; }
const StepReport& System::step_report() const { return impl_->report; }
const std::string& System::solver_choice() const {
  if (impl_->solver) return impl_->solver->choice();
  for (const auto* solver : {&impl_->tangent_solver, &impl_->mass_solver})
    if (*solver && !(*solver)->choice().empty()) return (*solver)->choice();
  if (impl_->jacobian && !impl_->jacobian->choice().empty()) return impl_->jacobian->choice();
  return impl_->no_solver;
}

std::vector<std::string> System::notes() const {
  std::vector<std::string> notes;
  for (const SetPart& set : impl_->sets)
    for (const JetAssembler::Term& term : set.assembler.terms())
      if (set.assembler.is_numerical(term, {set.rest, set.rest, set.rest}))
        notes.push_back("the force of " + term.origin +
                        " is a numerical derivative of its energy density: it gives no stress");
  return notes;
}

void System::Impl::evaluate(const State& state, JetAssembler::Part part) {
  require_going_on();
  const Stopwatch watch(times.assembly, "geometry, stress and force");
  evaluate_geometry_and_stress(state.r, part);
  evaluate_tuples(state.r);
  evaluated_at = state.time;
  force.setZero();
  add_internal_force(force);
  external.add_force(state, normals, force);
  add_material_damping(state, force);
}

void System::evaluate(const State& state) {
  impl_->evaluate(state, JetAssembler::Part::stress);
  if (!impl_->force.allFinite()) throw_force_not_finite(state);
}

void System::throw_force_not_finite(const State& state) {
  const Index node = first_not_finite(impl_->force);
  (void)external_force(state);  // each part by itself: the guilty one throws
  for (std::size_t t = 0; t < impl_->parts.energies.size(); ++t) (void)internal_force(t, state);
  throw NotFinite("the sum of all forces is not finite", node, largest_force_at(node, state));
}

void System::evaluate_with_operator(const State& state) {
  impl_->evaluate(state, JetAssembler::Part::stress_and_couplings);
  if (!impl_->force.allFinite()) throw_force_not_finite(state);
  const Stopwatch watch(impl_->times.assembly, "lagged operator");
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
  if (!impl_->operator_is_finite()) throw_operator_not_finite(state);
}

void System::throw_operator_not_finite(const State& state) {
  for (const auto& field : impl_->external.fields()) {
    NodeValues stiffness = NodeValues::Zero(nodes()), damping = stiffness;
    impl_->external.add_tangent(state, impl_->normals, stiffness, damping, &field);
    require_finite(stiffness + damping, "the tangent", field.origin, field.name);
  }
  for (std::size_t t = 0; t < impl_->parts.energies.size(); ++t) {
    const SparseMatrix k = lagged_force(t, state).k;
    NodeValues sums = NodeValues::Zero(nodes());
    for (Index a = 0; a < nodes(); ++a)
      for (std::int32_t p = k.row_begin[static_cast<std::size_t>(a)];
           p < k.row_begin[static_cast<std::size_t>(a) + 1]; ++p)
        sums[a] += k.value[static_cast<std::size_t>(p)];
    const Named<EnergyTerm>& term = impl_->parts.energies[t];
    require_finite(sums, "the lagged operator", term.origin, term.name);
  }
  throw NotFinite("the sum of all lagged operators is not finite", -1, "lagged operator");
}

void System::choose_solver() {
  if (impl_->solver) return;
  const bool symmetric = std::ranges::none_of(
      impl_->traits, [](const TermTraits& t) { return t.lagged == Lagged::unsymmetric; });
  impl_->solver.emplace(*impl_->map, impl_->k, symmetric, impl_->parts.make_solvers);
}

/// A term that promises symmetry without having it would be solved by half of its operator,
/// silently.
void System::require_promised_symmetry() {
  const State state{impl_->known[impl_->current], NodeVectors::Zero(nodes(), 3), 0};
  for (std::size_t t = 0; t < impl_->traits.size(); ++t) {
    if (impl_->traits[t].lagged != Lagged::symmetric) continue;
    const SparseMatrix k = lagged_force(t, state).k;
    const double asymmetry = largest_asymmetry(k), largest = largest_entry(k);
    if (asymmetry > kRoundingOfSums * largest)
      throw PluginFailure(
          "plugin " + impl_->parts.energies[t].origin +
          " promises a symmetric lagged operator, but an entry and its mirror image differ by " +
          std::to_string(asymmetry) + " (largest entry " + std::to_string(largest) + ")");
  }
}

void System::solve(const NodeValues& d, const NodeVectors& b, NodeVectors& x, double tolerance) {
  impl_->require_going_on();
  require_finite(d, "what is added to the lagged operator", "the integrator", "");
  require_finite(b, "the right-hand side", "the integrator", "");
  choose_solver();
  if (impl_->version <= 2) require_promised_symmetry();  // a rest state's operator may be 0
  impl_->solver->solve(impl_->k, impl_->version, d, b, x, tolerance, impl_->times);
}

void System::prescribe(double time, NodeVectors& r) const {
  if (impl_->parts.constraints.empty()) return;
  for (const auto& c : impl_->parts.constraints) {
    guarded(c.origin, "prescribing positions", [&] { c.object->prescribe(time, r); });
    if (r.rows() != nodes())
      throw PluginFailure("plugin " + c.origin + " made " + std::to_string(r.rows()) +
                          " positions of the " + std::to_string(nodes()) + " that it was given");
  }
  for (int c = 0; c < 3; ++c)
    for (Index a = 0; a < r.rows(); ++a)
      if (!std::isfinite(r(a, c)) && impl_->map->reduction().prescribed(a, c))
        throw_prescribed_not_finite(time, a);
  impl_->map->complete_positions(r);
}

void System::throw_prescribed_not_finite(double time, Index node) const {
  for (const auto& c : impl_->parts.constraints) {
    NodeVectors alone = NodeVectors::Zero(nodes(), 3);  // what is in r may be another's
    guarded(c.origin, "prescribing positions", [&] { c.object->prescribe(time, alone); });
    require_finite(alone, "a prescribed position", c.origin, c.name);
  }
  throw NotFinite("a prescribed position is not finite", node, "constraints");
}

void System::constrain(const NodeVectors& before, double step, State& after) const {
  prescribe(after.time, after.r);
  for (int c = 0; c < 3; ++c)
    for (Index a = 0; a < before.rows(); ++a)
      if (!impl_->map->reduction().free(a, c))
        after.v(a, c) = (after.r(a, c) - before(a, c)) / step;
}

std::vector<Index> System::collide(const NodeVectors& before, double step, State& after) {
  return impl_->contacts->resolve(before, step, after);
}

void System::find_contacts(double time, const NodeVectors& from, const NodeVectors& r,
                           double within, std::vector<NodeContact>& contacts) const {
  impl_->contacts->find(time, from, r, within, contacts);
}

void System::settle(double step, const std::vector<ContactImpulse>& impulses, State& state) const {
  impl_->contacts->settle(step, impulses, state);
}

std::size_t System::colliders() const { return impl_->parts.bodies.size(); }

NodeValues System::clearance(double time, const NodeVectors& points) const {
  return impl_->contacts->clearance(time, points);
}

void System::require_outside_of_colliders(const NodeVectors& r, double slack) const {
  impl_->contacts->require_outside(r, slack);
}

double System::energy(std::size_t term, const State& state) {
  impl_->require_going_on();
  for (const TupleAssembler& t : impl_->tuples)
    if (t.number() == term) {
      double sum = 0;
      const std::vector<double> energies =
          impl_->averages_strains ? impl_->mean_energies(t, state.r) : t.energies(state.r);
      for (std::size_t i = 0; i < energies.size(); ++i) {
        if (!std::isfinite(energies[i])) throw_energy_not_finite(term, t.first_node(i));
        sum += energies[i];
      }
      return sum;
    }
  impl_->update_geometry(state.r);
  std::vector<double>& density = impl_->energy_density;
  find_energy_density(term, density);
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
  std::vector<double> density;
  find_energy_density(term, density);
  return density;
}

void System::find_energy_density(std::size_t term, std::vector<double>& density) const {
  density.clear();
  for (SetPart& set : impl_->sets)
    if (const auto* t = set.assembler.find(term)) {
      density.resize(static_cast<std::size_t>(set.assembler.samples().size()));
      set.assembler.energy_density(*t, impl_->geometries(set), density);
      const auto bad = std::ranges::find_if_not(density, [](double e) { return std::isfinite(e); });
      if (bad != density.end())
        throw_energy_not_finite(
            term, set.assembler.samples().stencil(bad - density.begin()).nodes.front());
      return;
    }
}

void System::throw_energy_not_finite(std::size_t term, Index node) const {
  const Named<EnergyTerm>& guilty = impl_->parts.energies[term];
  throw NotFinite("the energy of " + guilty.origin + " is not finite", node, guilty.name);
}

double System::external_potential(const State& state) {
  impl_->update_geometry(state.r);
  double sum = 0;
  for (const double e : impl_->external.potential(state, impl_->normals)) sum += e;
  if (std::isfinite(sum)) return sum;
  for (const auto& field : impl_->external.fields())
    require_finite(impl_->external.potential(state, impl_->normals, &field), "the potential energy",
                   field.origin, field.name);
  throw NotFinite("the sum of all potential energies is not finite", -1, "external forces");
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
  const Named<EnergyTerm>& energy = impl_->parts.energies[term];
  require_finite(f, "the force", energy.origin, energy.name);
  return f;
}

NodeVectors System::external_force(const State& state) {
  impl_->update_geometry(state.r);
  NodeVectors f = NodeVectors::Zero(nodes(), 3);
  impl_->external.add_force(state, impl_->normals, f);
  if (f.allFinite()) return f;
  for (const auto& field : impl_->external.fields())
    require_finite(impl_->force_of(field, state), "the force", field.origin, field.name);
  throw NotFinite("the sum of all external forces is not finite", first_not_finite(f),
                  "external forces");
}

System::LaggedForce System::lagged_force(std::size_t term, const State& state) {
  impl_->require_going_on();
  impl_->update_geometry(state.r);
  LaggedForce result{impl_->k, NodeVectors::Zero(nodes(), 3)};
  std::ranges::fill(result.k.value, 0.0);
  for (SetPart& set : impl_->sets)
    if (const auto* t = set.assembler.find(term)) {
      set.assembler.evaluate(impl_->geometries(set), JetAssembler::Part::couplings_and_constant, t);
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
  impl_->update_geometry(state.r);
  std::string name = "no force";
  double largest = 0;
  const auto compare = [&](const NodeVectors& f, const std::string& of) {
    const double norm = f.row(node).norm();
    if (norm > largest) largest = norm, name = of;
  };
  for (const auto& field : impl_->external.fields())
    compare(impl_->force_of(field, state), field.name);
  for (std::size_t t = 0; t < impl_->parts.energies.size(); ++t)
    compare(internal_force(t, state), impl_->parts.energies[t].name);
  return name;
}

}  // namespace deform
