#include "solve/matrix/solver_queue.h"

#include <algorithm>

#include "deform/log.h"

#include "no_solver.h"
#include "not_finite.h"
#include "plugin/guard.h"

namespace deform {
namespace {

const char* kind_of(const MatrixTraits& traits) {
  return traits.symmetric ? "symmetric" : "unsymmetric";
}

}  // namespace

SolverQueue::SolverQueue(const SolverSource& solvers, const MatrixTraits& traits)
    : source_(solvers), traits_(traits), solvers_(solvers()) {
  const auto fit = [&](const Named<LinearSolver>& s) {
    return guarded(s.origin, "judging a matrix", [&] { return s.object->suitability(traits_); });
  };
  const std::string offered = solvers_.empty() ? "none was found" : solvers_.front().name;
  std::erase_if(solvers_, [&](const auto& s) { return fit(s) <= 0; });
  if (solvers_.empty())
    throw NoSolver(std::string("no linear solver takes this scene's ") + kind_of(traits_) +
                   " matrix (" + offered + ")");
  std::ranges::stable_sort(solvers_, std::ranges::greater{}, fit);
  if (fit(solvers_.front()) >= LinearSolver::kSuitable)
    std::erase_if(solvers_, [&](const auto& s) { return fit(s) < LinearSolver::kSuitable; });
  analysed_.assign(solvers_.size(), false);
}

std::string SolverQueue::choice(const SparseMatrix& a) const {
  return solvers_.front().name + " (matrix " + kind_of(traits_) + ", " + std::to_string(a.size) +
         " unknowns, " + std::to_string(a.column.size()) + " entries)";
}

Factorisation SolverQueue::factor_with(std::size_t i, const SparseMatrix& a) {
  const Named<LinearSolver>& solver = solvers_[i];
  if (!analysed_[i]) {
    guarded(solver.origin, "analysing a matrix", [&] { solver.object->analyse(a, traits_); });
    analysed_[i] = true;
  }
  in_use_ = i;
  return guarded(solver.origin, "factorising a matrix", [&] { return solver.object->factor(a); });
}

std::string SolverQueue::factor(const SparseMatrix& a) {
  matrix_ = &a;
  must_be_definite_ = false;
  return factor_from(0);
}

std::string SolverQueue::factor_definite(const SparseMatrix& a) {
  matrix_ = &a;
  must_be_definite_ = true;
  return factor_from(0);
}

std::string SolverQueue::factor_from(std::size_t first) {
  std::string reasons;
  for (std::size_t i = first; i < solvers_.size(); ++i) {
    const Factorisation made = factor_with(i, *matrix_);
    if (made.outcome == Outcome::solved) return "";
    reasons += (reasons.empty() ? "" : "; ") + solvers_[i].name + ": " + made.reason;
    if (must_be_definite_ && made.outcome == Outcome::indefinite) break;
    log_handover(i, made.reason);
  }
  return reasons;
}

void SolverQueue::log_handover(std::size_t from, const std::string& reason) {
  if (from + 1 == solvers_.size()) return;
  const std::string handover =
      "solver " + solvers_[from].name + " hands over to " + solvers_[from + 1].name;
  if (source_.is_new(handover)) log::warn(handover + ": " + reason);
}

std::string SolverQueue::solve(const Eigen::MatrixXd& b, Eigen::MatrixXd& x) {
  return solve_by([&](LinearSolver& solver) { solver.solve(b, x); });
}

std::string SolverQueue::solve(const Unknowns& unknowns, const NodeVectors& b, NodeVectors& x) {
  rhs_ = unknowns.reduced(b);
  solution_.resize(rhs_.rows(), 1);
  std::string reason = solve(rhs_, solution_);
  if (!reason.empty()) return reason;
  if (const Index q = first_not_finite(solution_); q >= 0 && rhs_.allFinite())
    throw NotFinite("the solution of " + in_use().origin + " is not finite", unknowns[q].node,
                    in_use().name);
  x = unknowns.expanded(solution_.col(0));
  return "";
}

std::string SolverQueue::improve(const Eigen::MatrixXd& b, double tolerance, Eigen::MatrixXd& x) {
  return solve_by([&](LinearSolver& solver) { solver.improve(b, tolerance, x); });
}

/// An iterative solver finds out only here that it cannot.
template <class Solve>
std::string SolverQueue::solve_by(const Solve& solve) {
  for (;;) {
    const Named<LinearSolver>& solver = in_use();
    std::string reason;
    try {
      guarded(solver.origin, "solving", [&] { solve(*solver.object); });
      return "";
    } catch (const Error& e) {
      if (e.code() != ExitCode::diverged) throw;
      reason = e.what();
    }
    if (in_use_ + 1 == solvers_.size()) return reason;
    log_handover(in_use_, reason);
    const std::string others = factor_from(in_use_ + 1);
    if (!others.empty()) return reason + "; " + others;
  }
}

}  // namespace deform
