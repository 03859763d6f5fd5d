/// Solves (s K + diag(d)) x = b with a tangent K of 3 × 3 blocks, on the free degrees of freedom.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "deform/model/reduction.h"
#include "deform/solve/block_matrix.h"
#include "deform/solve/system.h"

#include "solve/reduced_matrix.h"
#include "solve/solver_queue.h"

namespace deform {

class TangentSolver {
 public:
  TangentSolver(const ReductionMap& map, const BlockMatrix& pattern,
                const SolverQueue::MakeSolvers& make_solvers);

  /// Holds some unknowns where they are: those that would let the surface move as a rigid body.
  void hold(std::vector<Freedom> held);
  [[nodiscard]] Index unknowns() const { return unknowns_; }

  /// d: (N) for all three components. Returns "" or why the matrix is not positive definite.
  [[nodiscard]] std::string factor(const BlockMatrix& k, const NodeValues& d);
  /// x = T y with Tᵀ(K + diag(d))T y = Tᵀb, of the last factor that could; b (N × 3), x (N × 3).
  void solve(const NodeVectors& b, NodeVectors& x);
  [[nodiscard]] std::string choice() const;

  /// The matrix itself, for eigenvalues.
  [[nodiscard]] const SparseMatrix& reduced(const BlockMatrix& k, const NodeValues& d);
  /// The entries of a field (N × 3) at the unknowns.
  [[nodiscard]] Eigen::VectorXd gathered(const NodeVectors& field) const;
  /// T y (N × 3) for unknowns y.
  [[nodiscard]] NodeVectors expanded(const Eigen::VectorXd& y) const;

 private:
  void number_unknowns();

  const ReductionMap* map_;
  const BlockMatrix* pattern_;
  SolverQueue::MakeSolvers make_solvers_;
  std::vector<Freedom> held_;
  Index unknowns_ = 0;
  std::vector<Freedom> freedom_of_;  // each unknown's
  std::optional<ReducedMatrix> matrix_;
  std::optional<SolverQueue> solvers_;
  NodeVectors residual_;
  Eigen::MatrixXd rhs_, solution_;
};

}  // namespace deform
