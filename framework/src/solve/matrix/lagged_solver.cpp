#include "solve/matrix/lagged_solver.h"

#include <algorithm>

#include "not_finite.h"
#include "solve/stopwatch.h"

namespace deform {
namespace {

std::vector<Tie> ties_of(const ReductionMap& map, int component) {
  std::vector<Tie> ties;
  for (const Tie& tie : map.ties())
    if (tie.freedom.component == component) ties.push_back(tie);
  return ties;
}

/// Whether two components are tied alike; what the offsets are is a matter of right-hand sides.
bool are_alike(const std::vector<Tie>& a, const std::vector<Tie>& b) {
  return std::ranges::equal(a, b, [](const Tie& s, const Tie& t) {
    return s.freedom.node == t.freedom.node &&
           std::ranges::equal(s.parts, t.parts, [](const Tie::Part& p, const Tie::Part& q) {
             return p.of.node == q.of.node && p.coefficient == q.coefficient;
           });
  });
}

}  // namespace

LaggedSolver::LaggedSolver(const ReductionMap& map, const SparseMatrix& pattern, bool symmetric,
                           const SolverSource& solvers)
    : map_(&map) {
  if (map.reduction().ties_mix_components())
    throw InputError(
        "a constraint ties components to others (x to z, say), as a clamp or symmetry that is not "
        "along an axis does: this integrator solves for x, y and z one by one and cannot; those "
        "that use Newton's method can");
  traits_.symmetric = symmetric;
  traits_.positive_definite = symmetric;  // inertia dominates for steps that resolve the motion
  for (int c = 0; c < 3; ++c) {
    std::vector<Index> free = map.reduction().free_nodes(c);
    if (free.empty()) continue;
    std::vector<Tie> ties = ties_of(map, c);
    const auto same = std::ranges::find_if(
        groups_, [&](const Group& g) { return g.free == free && are_alike(g.ties, ties); });
    if (same != groups_.end()) {
      same->components.push_back(c);
      continue;
    }
    Group& group = groups_.emplace_back();
    group.components = {c};
    group.free = std::move(free);
    group.ties = std::move(ties);
  }
  for (Group& group : groups_) {
    make_group(group, pattern);
    MatrixTraits traits = traits_;
    traits.size = group.matrix->matrix().size;
    group.nodes.assign(group.free.begin(), group.free.end());
    traits.nodes = group.nodes;
    group.solvers.emplace(solvers, traits);
    choice_ = group.solvers->choice(group.matrix->matrix());
  }
}

/// The rows and columns of K at the free nodes, and what tied ones add to them.
void LaggedSolver::make_group(Group& group, const SparseMatrix& pattern) const {
  std::vector<Index> number(static_cast<std::size_t>(pattern.size), -1);
  for (std::size_t q = 0; q < group.free.size(); ++q)
    number[static_cast<std::size_t>(group.free[q])] = static_cast<Index>(q);
  ReducedMatrix::Rows rows(static_cast<std::size_t>(pattern.size));
  for (Index a = 0; a < pattern.size; ++a)
    for (const Tie::Part& part : map_->row({a, group.components.front()}))
      rows[static_cast<std::size_t>(a)].push_back(
          {number[static_cast<std::size_t>(part.of.node)], part.coefficient});
  const auto unknowns = static_cast<Index>(group.free.size());
  group.matrix.emplace(unknowns, rows, 1, [&](const ReducedMatrix::Visit& visit) {
    for (Index a = 0; a < pattern.size; ++a)
      for (std::int32_t p = pattern.row_begin[static_cast<std::size_t>(a)];
           p < pattern.row_begin[static_cast<std::size_t>(a) + 1]; ++p)
        visit(a, pattern.column[static_cast<std::size_t>(p)], p);
  });
  const auto columns = static_cast<Index>(group.components.size());
  group.rhs.resize(unknowns, columns);
  group.solution.resize(unknowns, columns);
}

void LaggedSolver::factor(Group& group, const SparseMatrix& k, const NodeValues& d) {
  group.matrix->fill(k.value, d);
  const std::string reasons = group.solvers->factor(group.matrix->matrix());
  if (!reasons.empty())
    throw Error(ExitCode::diverged,
                "no linear solver could factorise the matrix (" + reasons + ")");
}

/// Tᵀ(b − (K + D) x) for x with nothing but what is prescribed and what follows that.
void LaggedSolver::make_right_hand_side(Group& group, const SparseMatrix& k, const NodeValues& d,
                                        const NodeVectors& b, const NodeVectors& x) {
  residual_ = b;
  for (const int c : group.components) {
    if (x.col(c).isZero(0)) continue;
    const auto subtract = [&](Index a) {
      const auto row = static_cast<std::size_t>(a);
      double sum = residual_(a, c);
      for (std::int32_t p = k.row_begin[row]; p < k.row_begin[row + 1]; ++p)
        sum -= k.value[static_cast<std::size_t>(p)] * x(k.column[static_cast<std::size_t>(p)], c);
      residual_(a, c) = sum - d[a] * x(a, c);
    };
    for (const Index node : group.free) subtract(node);
    for (const Tie& tie : group.ties) subtract(tie.freedom.node);
  }
  if (!group.ties.empty()) map_->transpose(residual_);
  for (std::size_t j = 0; j < group.components.size(); ++j)
    for (std::size_t q = 0; q < group.free.size(); ++q)
      group.rhs(static_cast<Index>(q), static_cast<Index>(j)) =
          residual_(group.free[q], group.components[j]);
}

/// Names the solver and where there was the most to solve for; forces need not be at fault.
void LaggedSolver::throw_unsolved(const Group& group, const std::string& reason) {
  Index q = 0;
  group.rhs.rowwise().squaredNorm().maxCoeff(&q);
  throw NotFinite("the equations of a step cannot be solved (" + reason + ")",
                  group.free[static_cast<std::size_t>(q)], group.solvers->in_use().name);
}

void LaggedSolver::solve(const SparseMatrix& k, long version, const NodeValues& d,
                         const NodeVectors& b, NodeVectors& x, double tolerance) {
  if (version != factored_version_ || d != factored_d_) {
    const Stopwatch watch(&StepTimes::factorisation, "factorisation");
    factored_version_ = -1;
    for (Group& group : groups_) factor(group, k, d);
    factored_version_ = version;
    factored_d_ = d;
  }
  const Stopwatch watch(&StepTimes::solve, "solve");
  for (Group& group : groups_)
    for (std::size_t j = 0; j < group.components.size(); ++j)
      for (std::size_t q = 0; q < group.free.size(); ++q) {
        double& free = x(group.free[q], group.components[j]);
        group.solution(static_cast<Index>(q), static_cast<Index>(j)) = free;
        free = 0;
      }
  map_->complete_changes(x);
  for (Group& group : groups_) {
    make_right_hand_side(group, k, d, b, x);
    const std::string reason = group.solvers->improve(group.rhs, tolerance, group.solution);
    if (!reason.empty()) throw_unsolved(group, reason);
    if (const Index q = first_not_finite(group.solution); q >= 0 && group.rhs.allFinite())
      throw NotFinite("the solution of " + group.solvers->in_use().origin + " is not finite",
                      group.free[static_cast<std::size_t>(q)], group.solvers->in_use().name);
    for (std::size_t j = 0; j < group.components.size(); ++j)
      for (std::size_t q = 0; q < group.free.size(); ++q)
        x(group.free[q], group.components[j]) =
            group.solution(static_cast<Index>(q), static_cast<Index>(j));
  }
  map_->complete_changes(x);
}

}  // namespace deform
