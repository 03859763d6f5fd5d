#include "deform/solve/lagged_matrix.h"

#include <algorithm>
#include <optional>
#include <string>

#include "deform/solve/system.h"

#include "not_finite.h"
#include "solve/assembly/all_forces.h"
#include "solve/assembly/part_forces.h"
#include "solve/assembly/symmetry.h"
#include "solve/matrix/lagged_solver.h"
#include "solve/stopwatch.h"
#include "solve/system_parts.h"

namespace deform {
namespace {

/// So many operators are looked at before a promised symmetry is believed: a rest state's may be 0.
constexpr long kLooked = 2;

}  // namespace

struct LaggedMatrix::Impl {
  explicit Impl(SystemParts& of)
      : parts(&of),
        k(of.assembly.terms.lagged_pattern()),
        stiffness(NodeValues::Zero(k.size)),
        damping(stiffness) {}

  void add_to_diagonal();
  [[nodiscard]] bool is_finite() const;
  void require_promised_symmetry() const;

  SystemParts* parts;
  SparseMatrix k;
  NodeValues stiffness, damping;  // of force fields
  State at;                       // of an evaluation whose symmetry is looked at
  long version = 0;               // of its values
  std::optional<LaggedSolver> solver;
};

LaggedMatrix::LaggedMatrix(const System& system)
    : impl_(std::make_unique<Impl>(SystemParts::of(system))) {}
LaggedMatrix::~LaggedMatrix() = default;
const NodeValues& LaggedMatrix::force_damping() const { return impl_->damping; }
const SparseMatrix& LaggedMatrix::matrix() const { return impl_->k; }

void LaggedMatrix::Impl::add_to_diagonal() {
  for (Index a = 0; a < k.size; ++a) {
    const auto row = static_cast<std::size_t>(a);
    const auto begin = k.column.begin() + k.row_begin[row];
    const auto end = k.column.begin() + k.row_begin[row + 1];
    const auto place = std::lower_bound(begin, end, a) - k.column.begin();
    k.value[static_cast<std::size_t>(place)] += stiffness[a];
  }
}

bool LaggedMatrix::Impl::is_finite() const {
  const Eigen::Map<const Eigen::VectorXd> values(k.value.data(),
                                                 static_cast<Index>(k.value.size()));
  return values.allFinite() && stiffness.allFinite() && damping.allFinite();
}

void LaggedMatrix::evaluate(const State& state, NodeVectors& f) {
  Impl& i = *impl_;
  Assembly& assembly = i.parts->assembly;
  const auto now =
      sum_all_forces(assembly, state, nullptr, JetAssembler::Part::stress_and_couplings, f);
  if (!f.allFinite()) throw_force_not_finite(assembly, state, f);
  const Stopwatch watch(&StepTimes::assembly, "lagged operator");
  std::ranges::fill(i.k.value, 0.0);
  for (const SetTerms& set : assembly.terms.sets()) set.assembler.add_operator(i.k);
  for (const TupleAssembler& t : assembly.terms.tuples()) t.add_operator(i.k);
  i.stiffness.setZero();
  i.damping.setZero();
  assembly.terms.external().add_tangent(state, now->normals, i.stiffness, i.damping);
  i.add_to_diagonal();
  if (++i.version <= kLooked) i.at = state;
  if (!i.is_finite()) throw_lagged_not_finite(assembly, state);
}

void LaggedMatrix::choose_solver() {
  Impl& i = *impl_;
  if (i.solver) return;
  const bool symmetric =
      std::ranges::none_of(i.parts->assembly.terms.traits(),
                           [](const TermTraits& t) { return t.lagged == Lagged::unsymmetric; });
  i.solver.emplace(i.parts->constraints.map(), i.k, symmetric, i.parts->solvers);
  i.parts->meter.choose(WorkMeter::Matrix::lagged, i.solver->choice());
}

/// A term that promises symmetry without having it would be solved by half of its operator,
/// silently.
void LaggedMatrix::Impl::require_promised_symmetry() const {
  const ModelTerms& terms = parts->assembly.terms;
  for (std::size_t t = 0; t < terms.traits().size(); ++t) {
    if (terms.traits()[t].lagged != Lagged::symmetric) continue;
    SparseMatrix of_term;
    NodeVectors c = NodeVectors::Zero(k.size, 3);
    lagged_force(parts->assembly, t, at, of_term, c);
    const double asymmetry = largest_asymmetry(of_term), largest = largest_entry(of_term);
    if (asymmetry > kRoundingOfSums * largest)
      throw PluginFailure(
          "plugin " + terms.energy(t).origin +
          " promises a symmetric lagged operator, but an entry and its mirror image differ by " +
          std::to_string(asymmetry) + " (largest entry " + std::to_string(largest) + ")");
  }
}

void LaggedMatrix::solve(const NodeValues& d, const NodeVectors& b, NodeVectors& x,
                         double tolerance) {
  Impl& i = *impl_;
  i.parts->meter.require_going_on();
  require_finite(d, "what is added to the lagged operator", "the integrator", "");
  require_finite(b, "the right-hand side", "the integrator", "");
  choose_solver();
  if (i.version <= kLooked) i.require_promised_symmetry();
  i.solver->solve(i.k, i.version, d, b, x, tolerance);
}

}  // namespace deform
