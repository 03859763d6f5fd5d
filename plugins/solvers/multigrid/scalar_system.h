/// Systems with one unknown a node and several right-hand sides, solved in double precision.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <deform/solve/sparse_matrix.h>

#include "conjugate_gradients.h"
#include "cycle.h"

namespace multigrid {

/// Matrix and solution are in double precision; corrections, and what preconditions them, in
/// single.
class ScalarSystem {
 public:
  /// `nodes`: of each unknown; `total`: of the surface.
  ScalarSystem(const deform::SparseMatrix& pattern, std::span<const std::int32_t> nodes,
               Index total, const std::vector<deform::Prolongation>& coarsening);

  void factor(const deform::SparseMatrix& a);
  /// Up to three right-hand sides, from a guess x; "" or why not.
  [[nodiscard]] std::string improve(const Eigen::Ref<const Eigen::MatrixXd>& b, double tolerance,
                                    int most, Eigen::Ref<Eigen::MatrixXd> x);
  [[nodiscard]] int iterations() const { return iterations_; }

 private:
  [[nodiscard]] std::string improve_nodes(double tolerance, int most);
  [[nodiscard]] bool find_residual_is_rounding();
  [[nodiscard]] Ending correct(Goal goal, int most);
  [[nodiscard]] double norm(const Field<double>& y);

  /// Of the upper half: where in the matrix that is given, and in the strips.
  struct Entry {
    std::int32_t from;
    std::int64_t to;
  };
  std::vector<std::int32_t> node_;      // of an unknown
  std::vector<std::size_t> row_begin_;  // of an unknown, in entries_; its diagonal's first
  std::vector<Entry> entries_;
  std::vector<double> value_;  // of the last factor
  std::optional<Cycle<Scalar>> cycle_;
  double largest_diagonal_ = 0;
  Product<double> product_;
  ConjugateGradients gradients_;
  Field<double> b_, x_, product_of_x_;
  Sums sums_;
  int iterations_ = 0;
};

}  // namespace multigrid
