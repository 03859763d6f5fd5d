/// Solves (K + diag(d)) x = b with a tangent K of 3 × 3 blocks, on the free degrees of freedom.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "deform/solve/block_matrix.h"
#include "deform/solve/system.h"

#include "solve/reduced_matrix.h"
#include "solve/solver_queue.h"
#include "solve/unknowns.h"

namespace deform {

class TangentSolver {
 public:
  /// `held`: unknowns that stay where they are, so that the surface does not move as a rigid body.
  TangentSolver(const ReductionMap& map, const BlockMatrix& pattern,
                const std::vector<Freedom>& held, const SolverQueue::MakeSolvers& make_solvers);

  [[nodiscard]] const Unknowns& unknowns() const { return unknowns_; }

  /// d: (N) for all three components. Returns "" or why the matrix is not positive definite.
  [[nodiscard]] std::string factor(const BlockMatrix& k, const NodeValues& d);
  /// x = T y with Tᵀ(K + diag(d))T y = Tᵀb, of the last factor that could; b (N × 3), x (N × 3).
  void solve(const NodeVectors& b, NodeVectors& x);

  /// Tᵀ(K + diag(d))T, for eigenvalues.
  [[nodiscard]] const SparseMatrix& reduced(const BlockMatrix& k, const NodeValues& d);

 private:
  Unknowns unknowns_;
  ReducedMatrix matrix_;
  SolverQueue::MakeSolvers make_solvers_;
  std::optional<SolverQueue> solvers_;  // made when first needed
  Eigen::MatrixXd rhs_, solution_;
};

}  // namespace deform
