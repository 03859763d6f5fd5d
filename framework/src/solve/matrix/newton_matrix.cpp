#include "deform/solve/newton_matrix.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "deform/solve/system.h"

#include "not_finite.h"
#include "profile/profile.h"
#include "solve/assembly/part_forces.h"
#include "solve/assembly/step_strains_impl.h"
#include "solve/matrix/growing_pattern.h"
#include "solve/matrix/lowest_eigenvalue.h"
#include "solve/matrix/rigid_modes.h"
#include "solve/matrix/tangent_solver.h"
#include "solve/stopwatch.h"
#include "solve/system_parts.h"

namespace deform {
namespace {

/// Of the mean mass: what a scalar unknown without one has for eigenvalues.
constexpr double kLeastMass = 1e-9;

bool is_finite_everywhere(const std::vector<double>& values) {
  return Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Index>(values.size()))
      .allFinite();
}

}  // namespace

struct NewtonMatrix::Impl {
  explicit Impl(SystemParts& of) : parts(&of), pattern(of.assembly.tangents.pattern()) {}

  [[nodiscard]] WorkMeter& meter() const { return parts->meter; }
  [[nodiscard]] bool has_more_than_rows(double rate, Strains* strains) const;
  [[nodiscard]] bool make_rows(const StateGeometry& now, const TangentBuilder::TakeRows& take);
  [[nodiscard]] bool give_to_solver(const StateGeometry& now);
  [[nodiscard]] bool make_whole(const StateGeometry& now);
  [[nodiscard]] bool add_beside_rows(std::span<const BlockEntry> entries);
  /// Means of strains that a step averages are of whatever was evaluated last.
  void update_mean(const StateGeometry& now) const {
    Strains* const strains = impl_of(request.strains);
    if (averages(strains)) strains->update_mean(now);
  }
  void add_other_parts(const State& state, const StateGeometry& now);
  const BlockMatrix& whole();
  TangentSolver& made_solver();
  void report_choice() { meter().choose(WorkMeter::Matrix::newton, solver->choice()); }
  [[nodiscard]] RigidStiffness rigid_stiffness_of_forces(const State& state);

  SystemParts* parts;
  GrowingPattern pattern;
  BlockMatrix& k = pattern.matrix;  // with values where it `is_whole`
  TangentRequest request;           // of the last evaluation …
  NodeVectors before;               // … and what it pointed at
  State at;                         // … and its state
  bool is_evaluated = false, is_whole = false, solver_has_rows = false;
  NodeValues stiffness, damping;  // of force fields, (N) [N/m], [N·s/m]
  NodeValues diagonal;            // both together; no part of the rows that a solver is given
  NodeValues beside_rows;         // that, and what a solution adds
  NodeBlocks blocks;              // that were added to the rows of a solver, where there are any
  const NodeBlocks no_blocks{0, 6};
  bool has_blocks = false;
  std::vector<Freedom> held;
  std::optional<TangentSolver> solver;
  long step = -1;  // in which an iterative solver was last prepared: it takes nothing from earlier
};

NewtonMatrix::NewtonMatrix(const System& system)
    : impl_(std::make_unique<Impl>(SystemParts::of(system))) {}
NewtonMatrix::~NewtonMatrix() = default;

/// Whether a tangent has more than what terms on jets and diagonals give.
bool NewtonMatrix::Impl::has_more_than_rows(double rate, Strains* strains) const {
  Assembly& assembly = parts->assembly;
  return !assembly.terms.tuples().empty() || rate_of(strains) > 0 ||
         (rate != 0 && assembly.damping.is_any()) || assembly.terms.external().has_exact_tangent();
}

TangentSolver& NewtonMatrix::Impl::made_solver() {
  if (!solver)
    solver.emplace(parts->constraints.map(), k, held, parts->solvers,
                   [this]() -> const BlockMatrix& { return whole(); });
  return *solver;
}

/// Rows of terms on jets; returns whether they are finite.
bool NewtonMatrix::Impl::make_rows(const StateGeometry& now, const TangentBuilder::TakeRows& take) {
  ModelTerms& terms = parts->assembly.terms;
  Strains* const strains = impl_of(request.strains);
  const bool is_mixed = request.kind == Tangent::mixed && before.rows() > 0;
  const auto earlier = is_mixed ? terms.geometry_at(before) : nullptr;
  const auto geometries = terms.geometries_of_sets([&](std::size_t i) -> Geometries {
    const Geometries of = terms.geometries(i, now, strains);
    return is_mixed ? Geometries{of.now, earlier->of_set[i], of.rest, nullptr, of.mean} : of;
  });
  return parts->assembly.tangents.make_rows({geometries, request.kind, {}}, take);
}

bool NewtonMatrix::Impl::give_to_solver(const StateGeometry& now) {
  is_whole = false, solver_has_rows = true;
  return make_rows(now, [&](const BlockRows& rows) {
    solver->put(rows);
    return true;
  });
}

/// The rows, and the diagonal, to the whole matrix.
bool NewtonMatrix::Impl::make_whole(const StateGeometry& now) {
  is_whole = true, solver_has_rows = false;
  k.value.resize(9 * k.column.size());
  const bool is_finite = make_rows(now, [&](const BlockRows& rows) { return pattern.store(rows); });
  for (Index a = 0; a < k.nodes; ++a) k.block(a, a).diagonal().array() += diagonal[a];
  for (Index a = 0; has_blocks && a < k.nodes; ++a) {
    const auto b = blocks.row(a);
    k.block(a, a) +=
        (Eigen::Matrix3d() << b[0], b[1], b[2], b[1], b[3], b[4], b[2], b[4], b[5]).finished();
  }
  has_blocks = false;
  return is_finite;
}

/// Adds to what a solver got as rows; false where that takes the whole matrix.
bool NewtonMatrix::Impl::add_beside_rows(std::span<const BlockEntry> entries) {
  const bool are_diagonal = std::ranges::all_of(
      entries, [this](const BlockEntry& e) { return e.a == e.b && e.a >= 0 && e.a < k.nodes; });
  if (!solver_has_rows || is_whole || !are_diagonal) return false;
  if (!std::exchange(has_blocks, true)) blocks.setZero(k.nodes, 6);
  for (const BlockEntry& e : entries) {
    const Eigen::Matrix3d& m = e.block;
    blocks.row(e.a) +=
        (Eigen::Matrix<double, 1, 6>() << m(0, 0), m(0, 1), m(0, 2), m(1, 1), m(1, 2), m(2, 2))
            .finished();
  }
  return true;
}

const BlockMatrix& NewtonMatrix::Impl::whole() {
  if (is_whole || !is_evaluated) return k;
  const Span span("tangent once more");
  const auto now = parts->assembly.terms.geometry_at(at.r);
  update_mean(*now);
  (void)make_whole(*now);
  return k;
}

/// What is not of terms on jets, nor on the diagonal.
void NewtonMatrix::Impl::add_other_parts(const State& state, const StateGeometry& now) {
  Assembly& assembly = parts->assembly;
  Strains* const strains = impl_of(request.strains);
  for (TupleAssembler& t : assembly.terms.tuples()) t.add_tangent(state.r, request.kind, k);
  assembly.damping.add_tangent(now, strains, request.kind, request.rate, k);
  assembly.terms.external().add_exact_tangent(state, now.normals, request.rate, k);
}

void NewtonMatrix::evaluate(const State& state, const TangentRequest& request) {
  Impl& i = *impl_;
  ModelTerms& terms = i.parts->assembly.terms;
  i.meter().require_going_on();
  const Stopwatch watch(&StepTimes::assembly, "tangent");
  Strains* const strains = impl_of(request.strains);
  const auto now = terms.geometry_at(state.r);
  i.request = request;
  i.update_mean(*now);
  if (request.before != nullptr)
    i.before = *request.before;
  else
    i.before.resize(0, 3);
  i.at = state;
  i.is_evaluated = true;
  i.has_blocks = false;
  i.stiffness.setZero(terms.rows());
  i.damping.setZero(terms.rows());
  terms.external().add_tangent(state, now->normals, i.stiffness, i.damping, nullptr, true);
  i.diagonal = i.stiffness + request.rate * i.damping;
  bool is_finite = i.stiffness.allFinite() && i.damping.allFinite();
  const bool has_more = i.has_more_than_rows(request.rate, strains);
  const bool are_rows_all = request.for_directions && !has_more && !i.pattern.is_grown();
  if (are_rows_all && i.made_solver().takes_rows()) {
    is_finite &= i.give_to_solver(*now);
  } else {
    is_finite &= i.make_whole(*now);
    i.add_other_parts(state, *now);
    // A pass over the whole matrix only where more was added to it.
    is_finite &= !has_more || is_finite_everywhere(i.k.value);
  }
  if (!is_finite)
    throw NotFinite("the tangent is not finite", -1, largest_force_at(i.parts->assembly, 0, state));
}

void NewtonMatrix::add(std::span<const BlockEntry> entries) {
  if (entries.empty()) return;
  Impl& i = *impl_;
  if (i.add_beside_rows(entries)) return;
  (void)i.whole();
  i.solver_has_rows = false;
  if (i.pattern.grow(entries)) i.solver.reset();
  for (const BlockEntry& e : entries) i.pattern.add(e);
}

const BlockMatrix& NewtonMatrix::matrix() { return impl_->whole(); }

NodeValues NewtonMatrix::mean_stiffness() {
  const BlockMatrix& k = impl_->whole();
  NodeValues mean(k.nodes);
  for (Index a = 0; a < k.nodes; ++a) {
    const double* block = k.value.data() + 9 * Index{k.row_begin[static_cast<std::size_t>(a)]};
    mean[a] = (block[0] + block[4] + block[8]) / 3;
  }
  return mean;
}

std::string NewtonMatrix::factor(const NodeValues& d) {
  impl_->meter().require_going_on();
  require_finite(d, "what is added to the tangent", "the integrator", "");
  const Stopwatch watch(&StepTimes::factorisation, "factorisation");
  std::string reason = impl_->made_solver().factor(d);
  impl_->report_choice();
  return reason;
}

std::string NewtonMatrix::solve(const NodeVectors& b, NodeVectors& x) {
  impl_->meter().require_going_on();
  require_finite(b, "the right-hand side", "the integrator", "");
  const Stopwatch watch(&StepTimes::solve, "solve");
  return impl_->solver->solve(b, x);
}

std::string NewtonMatrix::solve_to(double tolerance, const NodeValues& d, const NodeVectors& b,
                                   NodeVectors& x) {
  Impl& i = *impl_;
  i.meter().require_going_on();
  require_finite(d, "what is added to the tangent", "the integrator", "");
  TangentSolver& solver = i.made_solver();
  std::string reason;
  {
    const Stopwatch watch(&StepTimes::factorisation, "preparing the solver");
    const bool renews = std::exchange(i.step, i.meter().step) != i.meter().step;
    i.beside_rows = d;
    if (!i.is_whole)
      i.beside_rows += i.diagonal;
    else if (solver.takes_rows() && !std::exchange(i.solver_has_rows, true))
      solver.put(i.k);
    reason =
        solver.factor_to_tolerance(d, i.beside_rows, i.has_blocks ? i.blocks : i.no_blocks, renews);
    i.report_choice();
  }
  return reason.empty() ? solve_again(tolerance, b, x) : reason;
}

std::string NewtonMatrix::solve_again(double tolerance, const NodeVectors& b, NodeVectors& x) {
  Impl& i = *impl_;
  i.meter().require_going_on();
  require_finite(b, "the right-hand side", "the integrator", "");
  const Stopwatch watch(&StepTimes::solve, "solve");
  // What is positive semidefinite by construction is not called indefinite for a rounding.
  const bool must_be_definite = is_semidefinite(i.request.kind);
  std::string reason = i.solver->solve_to_tolerance(tolerance, must_be_definite, b, x);
  i.report_choice();
  return reason;
}

long NewtonMatrix::solver_iterations() const {
  return impl_->solver ? impl_->solver->iterations() : 0;
}

NewtonMatrix::Stability NewtonMatrix::stability() {
  Impl& i = *impl_;
  i.meter().require_going_on();
  TangentSolver& solver = i.made_solver();
  const Index nodes = i.k.nodes;
  const NodeValues zero = NodeValues::Zero(nodes);
  // Lumped masses of what is free: the row sums of TᵀMT.
  NodeVectors mass(nodes, 3);
  const NodeValues& own = i.parts->model.mass;
  for (int c = 0; c < 3; ++c) mass.col(c) = own.cwiseMax(kLeastMass * own.mean());
  const Eigen::VectorXd m = solver.unknowns().reduced(mass);
  const LowestEigenvalue lowest = lowest_eigenvalue(solver.reduced(zero), m);
  return {lowest.value, lowest.negative,
          lowest.vector.size() == 0 ? NodeVectors(NodeVectors::Zero(nodes, 3))
                                    : solver.unknowns().expanded(lowest.vector)};
}

/// Of the force fields at a state.
RigidStiffness NewtonMatrix::Impl::rigid_stiffness_of_forces(const State& state) {
  ModelTerms& terms = parts->assembly.terms;
  const auto now = terms.geometry_at(state.r);
  BlockMatrix stiffness_alone = parts->assembly.tangents.pattern();
  stiffness_alone.value.assign(9 * stiffness_alone.column.size(), 0.0);
  NodeVectors f = NodeVectors::Zero(state.r.rows(), 3);
  if (!terms.external().add_conservative_stiffness(state, now->normals, stiffness_alone, f))
    return {};
  return rigid_stiffness(stiffness_alone, f, state.r.topRows(terms.nodes()));
}

std::vector<Freedom> NewtonMatrix::hold_rigid_motions(const State& state) {
  Impl& i = *impl_;
  RigidStiffness forces = i.rigid_stiffness_of_forces(state);
  if (!forces.second.isZero(0)) {
    // Stiffness that is lost among the surface's own holds nothing: no solver would notice it.
    constexpr double kNoticed = 1e-12;
    evaluate(state);
    forces.least = std::max(forces.least, kNoticed * mean_stiffness().cwiseAbs().sum());
  }
  std::vector<Freedom> held = components_to_hold(
      i.parts->constraints.map(), state.r.topRows(i.parts->assembly.terms.nodes()), forces);
  if (held == i.held) return held;
  i.held = held;
  if (i.solver_has_rows) (void)i.whole();  // the next solver gets it
  i.solver_has_rows = false;
  i.solver.reset();
  return held;
}

}  // namespace deform
