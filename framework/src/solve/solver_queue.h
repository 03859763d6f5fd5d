/// The linear solvers that suit a matrix, best first; one that cannot hands over to the next. Those
/// whose suitability is below 1 are among them only where no other takes such matrices.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "deform/solve/sparse_matrix.h"
#include "deform/solve/system.h"

namespace deform {

class SolverQueue {
 public:
  using MakeSolvers = std::function<std::vector<Named<LinearSolver>>()>;

  /// Throws InputError when none takes such matrices.
  SolverQueue(const MakeSolvers& make_solvers, const MatrixTraits& traits);

  /// "" or why none could, each solver's reason.
  [[nodiscard]] std::string factor(const SparseMatrix& a);
  /// Only the first: what cannot be factorised is a result, too (a matrix that is indefinite).
  [[nodiscard]] std::string factor_with_first(const SparseMatrix& a);
  /// "" or why none could.
  [[nodiscard]] std::string solve(const Eigen::MatrixXd& b, Eigen::MatrixXd& x);
  /// From a guess, to a tolerance, where the solver can (LinearSolver::improve).
  [[nodiscard]] std::string improve(const Eigen::MatrixXd& b, double tolerance, Eigen::MatrixXd& x);
  [[nodiscard]] const Named<LinearSolver>& in_use() const { return solvers_[in_use_]; }
  /// "cholmod (matrix symmetric, 361 unknowns, 4000 entries)".
  [[nodiscard]] std::string choice(const SparseMatrix& a) const;

 private:
  template <class Solve>
  [[nodiscard]] std::string solve_by(const Solve& solve);
  [[nodiscard]] std::string factor_with(std::size_t i, const SparseMatrix& a);

  [[nodiscard]] std::string factor_from(std::size_t i);
  void log_handover(std::size_t from, const std::string& reason);

  MatrixTraits traits_;
  std::vector<Named<LinearSolver>> solvers_;
  std::vector<bool> analysed_;
  std::size_t in_use_ = 0;
  const SparseMatrix* matrix_ = nullptr;  // that all may factorise; null: the first alone
  long handovers_ = 0;
};

}  // namespace deform
