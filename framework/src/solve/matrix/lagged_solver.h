/// Solves (K + diag(d)) x = b, K shared by x, y and z, on the free degrees of freedom.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "deform/model/reduction.h"
#include "deform/solve/model_parts.h"
#include "deform/solve/sparse_matrix.h"

#include "solve/matrix/reduced_matrix.h"
#include "solve/matrix/solver_queue.h"

namespace deform {

/// Components with the same free nodes and ties share a matrix and its factor.
class LaggedSolver {
 public:
  /// Throws InputError when a tie mixes components, which such a matrix cannot say.
  LaggedSolver(const ReductionMap& map, const SparseMatrix& pattern, bool symmetric,
               const SolverSource& solvers);

  /// `version` changes whenever K's values do. Prescribed entries of x are given, the others a
  /// guess (LinearSolver::improve).
  void solve(const SparseMatrix& k, long version, const NodeValues& d, const NodeVectors& b,
             NodeVectors& x, double tolerance);
  [[nodiscard]] const std::string& choice() const { return choice_; }

 private:
  struct Group {
    std::vector<int> components;
    std::vector<Index> free;          // nodes
    std::vector<std::int32_t> nodes;  // the same, for solvers
    std::vector<Tie> ties;            // of the first component
    std::optional<ReducedMatrix> matrix;
    std::optional<SolverQueue> solvers;
    Eigen::MatrixXd rhs, solution;
  };

  void make_group(Group& group, const SparseMatrix& pattern) const;
  void factor(Group& group, const SparseMatrix& k, const NodeValues& d);
  [[noreturn]] static void throw_unsolved(const Group& group, const std::string& reason);
  void make_right_hand_side(Group& group, const SparseMatrix& k, const NodeValues& d,
                            const NodeVectors& b, const NodeVectors& x);

  const ReductionMap* map_;
  MatrixTraits traits_;
  std::vector<Group> groups_;
  std::string choice_;
  NodeVectors residual_;
  long factored_version_ = -1;
  NodeValues factored_d_;
};

}  // namespace deform
