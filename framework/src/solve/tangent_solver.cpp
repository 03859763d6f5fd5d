#include "solve/tangent_solver.h"

#include <algorithm>
#include <utility>

#include "solve/not_finite.h"

namespace deform {

TangentSolver::TangentSolver(const ReductionMap& map, const BlockMatrix& pattern,
                             const SolverQueue::MakeSolvers& make_solvers)
    : map_(&map), pattern_(&pattern), make_solvers_(make_solvers) {
  number_unknowns();
}

void TangentSolver::hold(std::vector<Freedom> held) {
  held_ = std::move(held);
  number_unknowns();
}

/// Unknowns node by node, x, y, z: what belongs together is close in the matrix.
void TangentSolver::number_unknowns() {
  const Index nodes = pattern_->nodes;
  std::vector<Index> number(static_cast<std::size_t>(3 * nodes), -1);
  freedom_of_.clear();
  for (Index a = 0; a < nodes; ++a)
    for (int c = 0; c < 3; ++c) {
      const Freedom freedom{a, c};
      if (!map_->reduction().free(a, c)) continue;
      if (std::ranges::find(held_, freedom) != held_.end()) continue;
      number[static_cast<std::size_t>(3 * a + c)] = static_cast<Index>(freedom_of_.size());
      freedom_of_.push_back(freedom);
    }
  unknowns_ = static_cast<Index>(freedom_of_.size());
  ReducedMatrix::Rows rows(static_cast<std::size_t>(3 * nodes));
  for (Index a = 0; a < nodes; ++a)
    for (int c = 0; c < 3; ++c)
      for (const Tie::Part& part : map_->row({a, c})) {
        const Index q = number[static_cast<std::size_t>(3 * part.of.node + part.of.component)];
        if (q >= 0) rows[static_cast<std::size_t>(3 * a + c)].push_back({q, part.coefficient});
      }
  matrix_.emplace(unknowns_, rows, [&](const ReducedMatrix::Visit& visit) {
    for (Index a = 0; a < nodes; ++a)
      for (std::int32_t p = pattern_->row_begin[static_cast<std::size_t>(a)];
           p < pattern_->row_begin[static_cast<std::size_t>(a) + 1]; ++p) {
        const Index b = pattern_->column[static_cast<std::size_t>(p)];
        for (Index i = 0; i < 3; ++i)
          for (Index j = 0; j < 3; ++j) {
            const Index place = 9 * p + 3 * i + j;
            visit(3 * a + i, 3 * b + j, place);
            if (a != b) visit(3 * b + j, 3 * a + i, place);
          }
      }
  });
  solvers_.reset();
  rhs_.resize(unknowns_, 1);
  solution_.resize(unknowns_, 1);
}

std::string TangentSolver::choice() const {
  return solvers_ ? solvers_->choice(matrix_->matrix()) : "none was needed";
}

const SparseMatrix& TangentSolver::reduced(const BlockMatrix& k, const NodeValues& d) {
  matrix_->fill(k.value, [&](Index freedom) { return d[freedom / 3]; });
  return matrix_->matrix();
}

std::string TangentSolver::factor(const BlockMatrix& k, const NodeValues& d) {
  if (!solvers_)
    solvers_.emplace(make_solvers_,
                     MatrixTraits{.size = unknowns_, .symmetric = true, .positive_definite = true});
  return solvers_->factor_with_first(reduced(k, d));
}

void TangentSolver::solve(const NodeVectors& b, NodeVectors& x) {
  residual_ = b;
  map_->transpose(residual_);
  rhs_.col(0) = gathered(residual_);
  solvers_->solve(rhs_, solution_);
  if (const Index q = first_not_finite(solution_); q >= 0 && rhs_.allFinite())
    throw NotFinite("the solution of " + solvers_->in_use().origin + " is not finite",
                    freedom_of_[static_cast<std::size_t>(q)].node, solvers_->in_use().name);
  x = expanded(solution_.col(0));
}

Eigen::VectorXd TangentSolver::gathered(const NodeVectors& field) const {
  Eigen::VectorXd values(unknowns_);
  for (Index q = 0; q < unknowns_; ++q) {
    const Freedom& f = freedom_of_[static_cast<std::size_t>(q)];
    values[q] = field(f.node, f.component);
  }
  return values;
}

NodeVectors TangentSolver::expanded(const Eigen::VectorXd& y) const {
  NodeVectors x = NodeVectors::Zero(pattern_->nodes, 3);
  for (Index q = 0; q < unknowns_; ++q) {
    const Freedom& f = freedom_of_[static_cast<std::size_t>(q)];
    x(f.node, f.component) = y[q];
  }
  map_->complete_changes(x);
  return x;
}

}  // namespace deform
