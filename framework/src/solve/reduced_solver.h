/// Solves (K + diag(d)) x = b on the free degrees of freedom: the reduction by constraints and the
/// choice of the linear solver.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "deform/model/constraint.h"
#include "deform/solve/sparse_matrix.h"
#include "deform/solve/system.h"

namespace deform {

/// Components with the same free nodes share a matrix and its factor.
class ReducedSolver {
 public:
  using MakeSolvers = std::function<std::vector<Named<LinearSolver>>()>;

  ReducedSolver(const Reduction& reduction, const SparseMatrix& pattern, bool symmetric,
                const MakeSolvers& make_solvers);

  /// `version` changes whenever K's values do. Prescribed entries of x are given.
  void solve(const SparseMatrix& k, long version, const NodeValues& d, const NodeVectors& b,
             NodeVectors& x, StepTimes& times);
  [[nodiscard]] const std::string& choice() const { return choice_; }

 private:
  struct Group {
    std::vector<int> components;
    std::vector<Index> free;                   // nodes
    SparseMatrix matrix;                       // free × free
    std::vector<std::int32_t> source;          // of each value: place in K's values
    std::vector<std::size_t> diagonal;         // place of each diagonal value
    std::vector<Named<LinearSolver>> solvers;  // best first
    std::vector<bool> analysed;
    std::size_t in_use = 0;
    Eigen::MatrixXd rhs, solution;
  };

  void make_group(Group& group, const SparseMatrix& pattern) const;
  void rank_solvers(Group& group);
  void factor(Group& group, const SparseMatrix& k, const NodeValues& d);

  MatrixTraits traits_;
  std::vector<Group> groups_;
  std::string choice_;
  long factored_version_ = -1;
  NodeValues factored_d_;
  long handovers_ = 0;
};

}  // namespace deform
