#include "solve/reduced_solver.h"

#include <algorithm>

#include "deform/log.h"

#include "plugin/guard.h"
#include "solve/not_finite.h"
#include "solve/stopwatch.h"

namespace deform {

ReducedSolver::ReducedSolver(const Reduction& reduction, const SparseMatrix& pattern,
                             bool symmetric, const MakeSolvers& make_solvers) {
  traits_.symmetric = symmetric;
  traits_.positive_definite = symmetric;  // inertia dominates for steps that resolve the motion
  for (int c = 0; c < 3; ++c) {
    std::vector<Index> free = reduction.free_nodes(c);
    const auto same = std::ranges::find(groups_, free, &Group::free);
    if (same != groups_.end()) {
      same->components.push_back(c);
      continue;
    }
    Group& group = groups_.emplace_back();
    group.components = {c};
    group.free = std::move(free);
  }
  std::erase_if(groups_, [](const Group& g) { return g.free.empty(); });
  for (Group& group : groups_) {
    make_group(group, pattern);
    group.solvers = make_solvers();
    rank_solvers(group);
  }
}

/// The rows and columns of K at the free nodes.
void ReducedSolver::make_group(Group& group, const SparseMatrix& pattern) const {
  std::vector<std::int32_t> number(static_cast<std::size_t>(pattern.size), -1);
  for (std::size_t q = 0; q < group.free.size(); ++q)
    number[static_cast<std::size_t>(group.free[q])] = static_cast<std::int32_t>(q);
  SparseMatrix& a = group.matrix;
  a.size = static_cast<Index>(group.free.size());
  for (const Index node : group.free) {
    const auto row = static_cast<std::size_t>(node);
    for (std::int32_t p = pattern.row_begin[row]; p < pattern.row_begin[row + 1]; ++p) {
      const std::int32_t column = pattern.column[static_cast<std::size_t>(p)];
      const std::int32_t q = number[static_cast<std::size_t>(column)];
      if (q < 0) continue;
      if (column == node) group.diagonal.push_back(a.column.size());
      a.column.push_back(q);
      group.source.push_back(p);
    }
    a.row_begin.push_back(static_cast<std::int32_t>(a.column.size()));
  }
  a.value.resize(a.column.size());
  const auto columns = static_cast<Index>(group.components.size());
  group.rhs.resize(a.size, columns);
  group.solution.resize(a.size, columns);
}

void ReducedSolver::rank_solvers(Group& group) {
  MatrixTraits traits = traits_;
  traits.size = group.matrix.size;
  const auto fit = [&](const Named<LinearSolver>& s) {
    return guarded(s.origin, "judging a matrix", [&] { return s.object->suitability(traits); });
  };
  const std::string kind = traits.symmetric ? "symmetric" : "unsymmetric";
  const std::string offered = group.solvers.empty() ? "none was found" : group.solvers.front().name;
  std::erase_if(group.solvers, [&](const auto& s) { return fit(s) <= 0; });
  if (group.solvers.empty())
    throw InputError("no linear solver takes this scene's " + kind + " matrix (" + offered + ")");
  std::ranges::stable_sort(group.solvers, std::ranges::greater{}, fit);
  group.analysed.assign(group.solvers.size(), false);
  choice_ = group.solvers.front().name + " (matrix " + kind + ", " +
            std::to_string(group.matrix.size) + " unknowns, " +
            std::to_string(group.matrix.column.size()) + " entries)";
}

void ReducedSolver::factor(Group& group, const SparseMatrix& k, const NodeValues& d) {
  SparseMatrix& a = group.matrix;
  for (std::size_t p = 0; p < a.value.size(); ++p)
    a.value[p] = k.value[static_cast<std::size_t>(group.source[p])];
  for (std::size_t q = 0; q < group.free.size(); ++q)
    a.value[group.diagonal[q]] += d[group.free[q]];

  MatrixTraits traits = traits_;
  traits.size = a.size;
  std::string reasons;
  for (std::size_t i = 0; i < group.solvers.size(); ++i) {
    const Named<LinearSolver>& solver = group.solvers[i];
    if (!group.analysed[i]) {
      guarded(solver.origin, "analysing a matrix", [&] { solver.object->analyse(a, traits); });
      group.analysed[i] = true;
    }
    const std::string reason =
        guarded(solver.origin, "factorising a matrix", [&] { return solver.object->factor(a); });
    if (reason.empty()) {
      group.in_use = i;
      return;
    }
    reasons += (reasons.empty() ? "" : "; ") + solver.name + ": " + reason;
    // Once in full: a matrix that is indefinite at one step mostly is at the next.
    if (i + 1 < group.solvers.size() && handovers_++ == 0)
      log::warn("solver " + solver.name + " hands over to " + group.solvers[i + 1].name + ": " +
                reason);
  }
  throw Error(ExitCode::diverged, "no linear solver could factorise the matrix (" + reasons + ")");
}

void ReducedSolver::solve(const SparseMatrix& k, long version, const NodeValues& d,
                          const NodeVectors& b, NodeVectors& x, StepTimes& times) {
  if (version != factored_version_ || d != factored_d_) {
    const Stopwatch watch(times.factorisation);
    factored_version_ = -1;
    for (Group& group : groups_) factor(group, k, d);
    factored_version_ = version;
    factored_d_ = d;
  }
  const Stopwatch watch(times.solve);
  for (Group& group : groups_) {
    // b_f − K_fp x_p: prescribed columns go to the right-hand side.
    for (std::size_t j = 0; j < group.components.size(); ++j) {
      const int c = group.components[j];
      for (const Index node : group.free) x(node, c) = 0;
      const bool moved = !x.col(c).isZero(0);
      for (std::size_t q = 0; q < group.free.size(); ++q) {
        const auto row = static_cast<std::size_t>(group.free[q]);
        double sum = b(group.free[q], c);
        for (std::int32_t p = k.row_begin[row]; moved && p < k.row_begin[row + 1]; ++p)
          sum -= k.value[static_cast<std::size_t>(p)] * x(k.column[static_cast<std::size_t>(p)], c);
        group.rhs(static_cast<Index>(q), static_cast<Index>(j)) = sum;
      }
    }
    const Named<LinearSolver>& solver = group.solvers[group.in_use];
    guarded(solver.origin, "solving", [&] { solver.object->solve(group.rhs, group.solution); });
    if (const Index q = first_not_finite(group.solution); q >= 0 && group.rhs.allFinite())
      throw NotFinite("the solution of " + solver.origin + " is not finite",
                      group.free[static_cast<std::size_t>(q)], solver.name);
    for (std::size_t j = 0; j < group.components.size(); ++j)
      for (std::size_t q = 0; q < group.free.size(); ++q)
        x(group.free[q], group.components[j]) =
            group.solution(static_cast<Index>(q), static_cast<Index>(j));
  }
}

}  // namespace deform
