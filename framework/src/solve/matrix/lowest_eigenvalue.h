/// The lowest eigenvalue of K x = λ M x.
#pragma once

#include "deform/solve/sparse_matrix.h"
#include "deform/types.h"

namespace deform {

struct LowestEigenvalue {
  double value = 0;        ///< λ
  Eigen::VectorXd vector;  ///< x, of unit length in M
  Index negative = 0;      ///< how many eigenvalues are negative
};

/// K symmetric, M (as m) diagonal and positive. By Lanczos' method on the inverse of K − σM with a
/// σ below all eigenvalues, which the inertia of a factorisation proves.
[[nodiscard]] LowestEigenvalue lowest_eigenvalue(const SparseMatrix& k, const Eigen::VectorXd& m);

}  // namespace deform
