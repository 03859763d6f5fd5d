/// The linear solvers that suit a matrix, best first; one that cannot hands over to the next. Those
/// whose suitability is below 1 are among them only where no other takes such matrices.
#pragma once

#include <string>
#include <vector>

#include "deform/solve/sparse_matrix.h"

#include "solve/matrix/solver_source.h"
#include "solve/matrix/unknowns.h"

namespace deform {

class SolverQueue {
 public:
  /// Throws InputError when none takes such matrices.
  SolverQueue(const SolverSource& solvers, const MatrixTraits& traits);

  /// "" or why none could, each solver's reason.
  [[nodiscard]] std::string factor(const SparseMatrix& a);
  /// The same, but that a matrix is not positive definite is a result, too: no other solver is
  /// asked after one that says so.
  [[nodiscard]] std::string factor_definite(const SparseMatrix& a);
  /// "" or why none could.
  [[nodiscard]] std::string solve(const Eigen::MatrixXd& b, Eigen::MatrixXd& x);
  /// The same for unknowns of fields b and x (N × 3): Tᵀb, T x. Throws NotFinite where a solution
  /// of finite forces is not finite.
  [[nodiscard]] std::string solve(const Unknowns& unknowns, const NodeVectors& b, NodeVectors& x);
  /// From a guess, to a tolerance, where the solver can (LinearSolver::improve).
  [[nodiscard]] std::string improve(const Eigen::MatrixXd& b, double tolerance, Eigen::MatrixXd& x);
  [[nodiscard]] const Named<LinearSolver>& in_use() const { return solvers_[in_use_]; }
  /// "cholmod (matrix symmetric, 361 unknowns, 4000 entries)".
  [[nodiscard]] std::string choice(const SparseMatrix& a) const;

 private:
  template <class Solve>
  [[nodiscard]] std::string solve_by(const Solve& solve);
  [[nodiscard]] Factorisation factor_with(std::size_t i, const SparseMatrix& a);

  [[nodiscard]] std::string factor_from(std::size_t i);
  void log_handover(std::size_t from, const std::string& reason);

  SolverSource source_;
  MatrixTraits traits_;
  std::vector<Named<LinearSolver>> solvers_;
  std::vector<bool> analysed_;
  std::size_t in_use_ = 0;
  const SparseMatrix* matrix_ = nullptr;
  Eigen::MatrixXd rhs_, solution_;  // of fields
  bool must_be_definite_ = false;
};

}  // namespace deform
