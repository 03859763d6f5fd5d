/// The part of a System that Newton's method needs: potential, tangent, solves with it.
#include <algorithm>
#include <cmath>
#include <utility>

#include "not_finite.h"
#include "solve/lowest_eigenvalue.h"
#include "solve/stopwatch.h"
#include "solve/system_impl.h"

namespace deform {
namespace {

bool is_finite_everywhere(const std::vector<double>& values) {
  return Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Index>(values.size()))
      .allFinite();
}

}  // namespace

/// Whether a tangent has more than what terms on jets and diagonals give.
bool System::Impl::adds_to_tangent(double rate) const {
  return !tuples.empty() || strain_rate > 0 || (rate != 0 && has_material_damping()) ||
         external.has_exact_tangent();
}

void System::Impl::make_tangent_pattern() {
  for (const SetPart& set : sets) tangents.add(set.assembler);
  std::vector<std::vector<std::int32_t>> rows(static_cast<std::size_t>(parts.surface->nodes()));
  const auto compress = [](std::vector<std::int32_t>& row) {
    std::ranges::sort(row);
    row.erase(std::unique(row.begin(), row.end()), row.end());
  };
  const auto add = [&](Index a, Index b) {
    auto& row = rows[static_cast<std::size_t>(std::min(a, b))];
    row.push_back(static_cast<std::int32_t>(std::max(a, b)));
    if (row.size() >= 256) compress(row);  // the same block comes from many samples
  };
  for (const TangentAssembler& t : tangents.sets()) t.visit_pattern(add);
  for (const TupleAssembler& t : tuples) t.visit_pattern(add);
  external.visit_pattern(add);
  tangent.nodes = parts.surface->nodes();
  for (std::size_t a = 0; a < rows.size(); ++a) {
    rows[a].push_back(static_cast<std::int32_t>(a));
    compress(rows[a]);
    tangent.column.insert(tangent.column.end(), rows[a].begin(), rows[a].end());
    tangent.row_begin.push_back(static_cast<std::int32_t>(tangent.column.size()));
  }
  tangents.bind(tangent);
}

void System::Impl::make_tangent_solver() {
  if (tangent_solver) return;
  tangent_solver.emplace(*map, tangent, held_freedoms, parts.make_solvers,
                         [this]() -> const BlockMatrix& { return whole_tangent(); });
}

std::span<const Geometries> System::Impl::geometries_of_tangent() {
  return geometries_of_sets([&](SetPart& set) {
    const Geometries at = geometries(set);
    return tangent_is_foreseen ? Geometries{at.now, set.before, at.rest, nullptr, at.mean} : at;
  });
}

/// Rows of terms on jets, as they are made; returns whether they are finite.
bool System::Impl::give_tangent_to_solver() {
  tangent_is_whole = false, solver_has_tangent = true;
  return tangents.make_rows({geometries_of_tangent(), tangent_kind, {}},
                            [&](const BlockRows& rows) {
                              tangent_solver->put(rows);
                              return true;
                            });
}

/// The same rows, and the diagonal, to the whole matrix.
bool System::Impl::make_tangent() {
  tangent_is_whole = true, solver_has_tangent = false;
  tangent.value.resize(9 * tangent.column.size());
  const bool is_finite = tangents.assemble({geometries_of_tangent(), tangent_kind, {}}, tangent);
  for (Index a = 0; a < tangent.nodes; ++a)
    tangent.block(a, a).diagonal().array() += tangent_diagonal[a];
  return is_finite;
}

const BlockMatrix& System::Impl::whole_tangent() {
  if (tangent_is_whole || tangent_at.rows() == 0) return tangent;
  const Span span("tangent once more");
  update_geometry(tangent_at);
  (void)make_tangent();
  return tangent;
}

/// What is not of terms on jets, nor on the diagonal.
void System::Impl::add_to_tangent(const State& state, double rate) {
  for (TupleAssembler& t : tuples) t.add_tangent(state.r, tangent_kind, tangent);
  if (strain_rate > 0) add_strain_damping_tangent(tangent_kind, tangent);
  if (rate != 0 && has_material_damping()) {
    update_damping(state.r);
    for (std::size_t i = 0; i < tangent.value.size(); ++i)
      tangent.value[i] += rate * damping.value[i];
  }
  external.add_exact_tangent(state, normals, rate, tangent);
}

const BlockMatrix& System::tangent() const { return impl_->whole_tangent(); }

void System::evaluate_with_tangent(const State& state, Tangent kind, const NodeVectors* before,
                                   double rate, TangentUse use) {
  evaluate(state);
  impl_->require_going_on();
  const Stopwatch watch(impl_->times.assembly, "tangent");
  if (impl_->tangent.nodes == 0) impl_->make_tangent_pattern();
  impl_->tangent_at = state.r;
  impl_->tangent_kind = kind;
  impl_->tangent_is_foreseen = kind == Tangent::foreseen && before != nullptr;
  if (impl_->tangent_is_foreseen)
    for (SetPart& set : impl_->sets) {
      if (set.before.size() == 0) set.before = Geometry(set.assembler.samples());
      set.compute(set.before, *before);
    }
  impl_->force_stiffness.setZero();
  impl_->force_damping.setZero();
  impl_->external.add_tangent(state, impl_->normals, impl_->force_stiffness, impl_->force_damping,
                              nullptr, true);
  impl_->tangent_diagonal = impl_->force_stiffness + rate * impl_->force_damping;
  const bool adds = impl_->adds_to_tangent(rate);
  bool is_finite = impl_->force_stiffness.allFinite() && impl_->force_damping.allFinite();
  if (use == TangentUse::directions && !adds) impl_->make_tangent_solver();
  if (use == TangentUse::directions && !adds && impl_->tangent_solver->takes_rows()) {
    is_finite &= impl_->give_tangent_to_solver();
  } else {
    is_finite &= impl_->make_tangent();
    impl_->add_to_tangent(state, rate);
    // A pass over the whole matrix only where more was added to it.
    is_finite &= !adds || is_finite_everywhere(impl_->tangent.value);
  }
  if (!is_finite) throw NotFinite("the tangent is not finite", -1, largest_force_at(0, state));
}

double System::potential(const State& state) {
  const Span span("potential");
  double sum = external_potential(state);
  for (std::size_t t = 0; t < impl_->parts.energies.size(); ++t) sum += energy(t, state);
  return sum;
}

std::vector<std::string> System::without_potential() const {
  std::vector<std::string> names = impl_->external.without_potential();
  for (std::size_t t = 0; t < impl_->traits.size(); ++t)
    if (!impl_->traits[t].potential) names.push_back(impl_->parts.energies[t].name);
  return names;
}

std::vector<std::string> System::without_tangent() const {
  std::vector<std::string> names = impl_->external.without_tangent();
  for (std::size_t t = 0; t < impl_->traits.size(); ++t)
    if (!impl_->traits[t].potential) names.push_back(impl_->parts.energies[t].name);
  return names;
}

void System::stiffen(Index node, const Eigen::Matrix3d& block) {
  (void)impl_->whole_tangent();
  impl_->solver_has_tangent = false;
  impl_->tangent.block(node, node) += block;
}

double System::root_mean_square(const NodeVectors& field) const {
  double sum = 0;
  for (Index c = 0; c < 3; ++c) sum += mass().dot(field.col(c).cwiseAbs2());
  return std::sqrt(sum / mass().sum());
}

NodeValues System::mean_stiffness() const {
  NodeValues mean(nodes());
  const BlockMatrix& k = impl_->whole_tangent();
  for (Index a = 0; a < k.nodes; ++a) {
    const double* block = k.value.data() + 9 * Index{k.row_begin[static_cast<std::size_t>(a)]};
    mean[a] = (block[0] + block[4] + block[8]) / 3;
  }
  return mean;
}

std::string System::factor_tangent(const NodeValues& d) {
  impl_->require_going_on();
  require_finite(d, "what is added to the tangent", "the integrator", "");
  const Stopwatch watch(impl_->times.factorisation, "factorisation");
  impl_->make_tangent_solver();
  return impl_->tangent_solver->factor(d);
}

std::string System::solve_tangent(const NodeVectors& b, NodeVectors& x) {
  impl_->require_going_on();
  require_finite(b, "the right-hand side", "the integrator", "");
  const Stopwatch watch(impl_->times.solve, "solve");
  return impl_->tangent_solver->solve(b, x);
}

std::string System::solve_tangent_to(double tolerance, const NodeValues& d, const NodeVectors& b,
                                     NodeVectors& x) {
  impl_->require_going_on();
  require_finite(d, "what is added to the tangent", "the integrator", "");
  impl_->make_tangent_solver();
  TangentSolver& solver = *impl_->tangent_solver;
  std::string reason;
  {
    const Stopwatch watch(impl_->times.factorisation, "preparing the solver");
    const bool renews = std::exchange(impl_->renews, false);
    impl_->solver_diagonal = d;
    if (!impl_->tangent_is_whole)
      impl_->solver_diagonal += impl_->tangent_diagonal;
    else if (solver.takes_rows() && !std::exchange(impl_->solver_has_tangent, true))
      solver.put(impl_->tangent);
    reason = solver.factor_to_tolerance(d, impl_->solver_diagonal, renews);
  }
  return reason.empty() ? solve_tangent_again(tolerance, b, x) : reason;
}

std::string System::solve_tangent_again(double tolerance, const NodeVectors& b, NodeVectors& x) {
  impl_->require_going_on();
  require_finite(b, "the right-hand side", "the integrator", "");
  TangentSolver& solver = *impl_->tangent_solver;
  const Stopwatch watch(impl_->times.solve, "solve");
  std::string reason = solver.solve_to_tolerance(tolerance, b, x);
  impl_->report.solver_iterations += solver.iterations();
  return reason;
}

double System::aim(const NodeVectors& r, const NodeVectors& d) {
  impl_->require_going_on();
  const Span span("turning");
  if (!impl_->turning)
    impl_->turning.emplace(surface(), rest(), *impl_->map, impl_->held_freedoms,
                           impl_->parts.make_solvers);
  return impl_->turning->aim(r, d);
}

void System::turn(double s, NodeVectors& r) { impl_->turning->take(s, r); }

System::Stability System::stability() {
  impl_->require_going_on();
  impl_->make_tangent_solver();
  const NodeValues zero = NodeValues::Zero(nodes());
  // Lumped masses of what is free: the row sums of TᵀMT.
  NodeVectors mass(nodes(), 3);
  for (int c = 0; c < 3; ++c) mass.col(c) = impl_->parts.mass;
  const Unknowns& unknowns = impl_->tangent_solver->unknowns();
  const Eigen::VectorXd m = unknowns.reduced(mass);
  const LowestEigenvalue lowest = lowest_eigenvalue(impl_->tangent_solver->reduced(zero), m);
  return {lowest.value, lowest.negative,
          lowest.vector.size() == 0 ? NodeVectors(NodeVectors::Zero(nodes(), 3))
                                    : unknowns.expanded(lowest.vector)};
}

/// Of the force fields at r and the time of the last evaluation.
RigidStiffness System::Impl::rigid_stiffness_of_forces(const NodeVectors& r) {
  update_geometry(r);
  if (tangent.nodes == 0) make_tangent_pattern();
  BlockMatrix stiffness = tangent;
  stiffness.value.assign(9 * stiffness.column.size(), 0.0);
  NodeVectors f = NodeVectors::Zero(r.rows(), 3);
  const State state{r, NodeVectors::Zero(r.rows(), 3), evaluated_at};
  if (!external.add_conservative_stiffness(state, normals, stiffness, f)) return {};
  return rigid_stiffness(stiffness, f, r);
}

/// What force fields hold is asked for the time of the last evaluation.
std::vector<Freedom> System::hold_rigid_motions(const NodeVectors& r) {
  RigidStiffness forces = impl_->rigid_stiffness_of_forces(r);
  if (!forces.second.isZero(0)) {
    // Stiffness that is lost among the surface's own holds nothing: no solver would notice it.
    constexpr double kNoticed = 1e-12;
    const double time = impl_->evaluated_at;
    evaluate_with_tangent({r, NodeVectors::Zero(nodes(), 3), time}, Tangent::exact);
    forces.least = std::max(forces.least, kNoticed * mean_stiffness().cwiseAbs().sum());
  }
  std::vector<Freedom> held = components_to_hold(*impl_->map, r, forces);
  if (held == impl_->held_freedoms) return held;
  impl_->held_freedoms = held;
  if (impl_->solver_has_tangent) (void)impl_->whole_tangent();  // the next solver gets it
  impl_->solver_has_tangent = false;
  impl_->tangent_solver.reset();
  impl_->turning.reset();
  impl_->jacobian.reset();
  return held;
}

void System::evaluate_with_jacobian(const State& state, double rate) {
  evaluate(state);
  const Stopwatch watch(impl_->times.assembly, "Jacobian");
  if (!impl_->jacobian)
    impl_->jacobian.emplace(*impl_->map, impl_->dependence(), impl_->held_freedoms,
                            impl_->parts.make_solvers);
  const NodeVectors known = impl_->force;
  State moved = state;
  impl_->jacobian->differentiate(state.r, [&](const NodeVectors& r) -> const NodeVectors& {
    moved.r = r;
    if (rate != 0) moved.v = state.v + rate * (r - state.r);
    evaluate(moved);
    return impl_->force;
  });
  impl_->force = known;
}

std::string System::factor_jacobian(const NodeValues& d) {
  impl_->require_going_on();
  const Stopwatch watch(impl_->times.factorisation, "factorisation");
  return impl_->jacobian->factor(d);
}

std::string System::solve_jacobian(const NodeVectors& b, NodeVectors& x) {
  impl_->require_going_on();
  require_finite(b, "the right-hand side", "the integrator", "");
  const Stopwatch watch(impl_->times.solve, "solve");
  return impl_->jacobian->solve(b, x);
}

/// Node by node, those whose positions its force depends on.
std::vector<std::vector<std::int32_t>> System::Impl::dependence() const {
  std::vector<std::vector<std::int32_t>> on(static_cast<std::size_t>(parts.surface->nodes()));
  const auto add = [&](Index a, Index b) {
    on[static_cast<std::size_t>(a)].push_back(static_cast<std::int32_t>(b));
  };
  const auto add_both = [&](Index a, Index b) { add(a, b), add(b, a); };
  for (const SetPart& set : sets) set.assembler.visit_dependence(add);
  for (const TupleAssembler& t : tuples) t.visit_pattern(add);
  external.visit_pattern(add_both);
  if (external.needs_neighbours()) {  // forces on faces
    const Faces& faces = parts.surface->faces();
    for (Index f = 0; f < faces.size(); ++f)
      for (std::int32_t i = faces.begin[static_cast<std::size_t>(f)];
           i < faces.begin[static_cast<std::size_t>(f) + 1]; ++i)
        for (std::int32_t j = faces.begin[static_cast<std::size_t>(f)];
             j < faces.begin[static_cast<std::size_t>(f) + 1]; ++j)
          add(faces.nodes[static_cast<std::size_t>(i)], faces.nodes[static_cast<std::size_t>(j)]);
  }
  for (std::size_t a = 0; a < on.size(); ++a) {
    on[a].push_back(static_cast<std::int32_t>(a));
    std::ranges::sort(on[a]);
    on[a].erase(std::unique(on[a].begin(), on[a].end()), on[a].end());
  }
  return on;
}

void System::follow_ties(NodeVectors& r) const { impl_->map->complete_positions(r); }
void System::follow_ties_of_velocity(NodeVectors& v) const { impl_->map->complete_changes(v); }
void System::reduce_force(NodeVectors& f) const { impl_->map->transpose(f); }

void System::accelerate(const NodeVectors& f, NodeVectors& acceleration) {
  require_finite(f, "the force to accelerate by", "the integrator", "");
  if (impl_->map->ties().empty()) {
    acceleration = f;
    impl_->map->transpose(acceleration);
    for (int c = 0; c < 3; ++c) acceleration.col(c).array() /= impl_->parts.mass.array();
    return;
  }
  if (!impl_->mass_solver) {
    BlockMatrix& none = impl_->no_stiffness;
    none.nodes = nodes();
    for (Index a = 0; a < nodes(); ++a) {
      none.column.push_back(static_cast<std::int32_t>(a));
      none.row_begin.push_back(static_cast<std::int32_t>(a + 1));
    }
    none.value.assign(9 * static_cast<std::size_t>(nodes()), 0.0);
    impl_->mass_solver.emplace(*impl_->map, none, std::vector<Freedom>{}, impl_->parts.make_solvers,
                               [&none]() -> const BlockMatrix& { return none; });
    const std::string reason = impl_->mass_solver->factor(impl_->parts.mass);
    if (!reason.empty())
      throw Error(ExitCode::diverged, "the matrix of masses cannot be factorised: " + reason);
  }
  const std::string reason = impl_->mass_solver->solve(f, acceleration);
  if (!reason.empty())
    throw Error(ExitCode::diverged, "the matrix of masses cannot be solved with: " + reason);
}

}  // namespace deform
