/// Systems with one unknown a node and several right-hand sides, solved in double precision.
#pragma once

#include <optional>
#include <string>

#include <deform/solve/sparse_matrix.h>

#include "conjugate_gradients.h"
#include "cycle.h"

namespace multigrid {

/// Three components of a node in double precision.
struct Triple {
  std::array<double, 3> v{};
  Triple& operator+=(const Triple& o) {
    for (std::size_t c = 0; c < 3; ++c) v[c] += o.v[c];
    return *this;
  }
  Triple& operator-=(const Triple& o) {
    for (std::size_t c = 0; c < 3; ++c) v[c] -= o.v[c];
    return *this;
  }
  friend Triple operator+(Triple a, const Triple& b) { return a += b; }
  friend Triple operator*(double s, const Triple& a) {
    return {{s * a.v[0], s * a.v[1], s * a.v[2]}};
  }
  friend double dot(const Triple& a, const Triple& b) {
    return a.v[0] * b.v[0] + a.v[1] * b.v[1] + a.v[2] * b.v[2];
  }
};

/// Conjugate gradients in double precision; only the preconditioner is in single.
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
  deform::SparseMatrix a_;          // of the last factor
  std::vector<std::int32_t> node_;  // of an unknown
  std::optional<Cycle<Scalar>> cycle_;
  ConjugateGradients<Triple, double> gradients_;
  std::vector<Triple> b_, x_;
  int iterations_ = 0;
};

}  // namespace multigrid
