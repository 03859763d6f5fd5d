#include "solve/solver_queue.h"

#include <algorithm>

#include "deform/log.h"

#include "plugin/guard.h"

namespace deform {
namespace {

const char* kind_of(const MatrixTraits& traits) {
  return traits.symmetric ? "symmetric" : "unsymmetric";
}

}  // namespace

SolverQueue::SolverQueue(const MakeSolvers& make_solvers, const MatrixTraits& traits)
    : traits_(traits), solvers_(make_solvers()) {
  const auto fit = [&](const Named<LinearSolver>& s) {
    return guarded(s.origin, "judging a matrix", [&] { return s.object->suitability(traits_); });
  };
  const std::string offered = solvers_.empty() ? "none was found" : solvers_.front().name;
  std::erase_if(solvers_, [&](const auto& s) { return fit(s) <= 0; });
  if (solvers_.empty())
    throw InputError(std::string("no linear solver takes this scene's ") + kind_of(traits_) +
                     " matrix (" + offered + ")");
  std::ranges::stable_sort(solvers_, std::ranges::greater{}, fit);
  analysed_.assign(solvers_.size(), false);
}

std::string SolverQueue::choice(const SparseMatrix& a) const {
  return solvers_.front().name + " (matrix " + kind_of(traits_) + ", " + std::to_string(a.size) +
         " unknowns, " + std::to_string(a.column.size()) + " entries)";
}

std::string SolverQueue::factor_with(std::size_t i, const SparseMatrix& a) {
  const Named<LinearSolver>& solver = solvers_[i];
  if (!analysed_[i]) {
    guarded(solver.origin, "analysing a matrix", [&] { solver.object->analyse(a, traits_); });
    analysed_[i] = true;
  }
  in_use_ = i;
  return guarded(solver.origin, "factorising a matrix", [&] { return solver.object->factor(a); });
}

std::string SolverQueue::factor_with_first(const SparseMatrix& a) {
  const std::string reason = factor_with(0, a);
  return reason.empty() ? "" : solvers_.front().name + ": " + reason;
}

std::string SolverQueue::factor(const SparseMatrix& a) {
  std::string reasons;
  for (std::size_t i = 0; i < solvers_.size(); ++i) {
    const std::string reason = factor_with(i, a);
    if (reason.empty()) return "";
    reasons += (reasons.empty() ? "" : "; ") + solvers_[i].name + ": " + reason;
    // Once in full: a matrix that is indefinite at one step mostly is at the next.
    if (i + 1 < solvers_.size() && handovers_++ == 0)
      log::warn("solver " + solvers_[i].name + " hands over to " + solvers_[i + 1].name + ": " +
                reason);
  }
  return reasons;
}

void SolverQueue::solve(const Eigen::MatrixXd& b, Eigen::MatrixXd& x) {
  const Named<LinearSolver>& solver = in_use();
  guarded(solver.origin, "solving", [&] { solver.object->solve(b, x); });
}

}  // namespace deform
