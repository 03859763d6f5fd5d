#include "solve/matrix/flexible_gmres.h"

#include <cmath>
#include <utility>
#include <vector>

#include <Eigen/Jacobi>

namespace deform {
namespace {

double dot(const NodeVectors& a, const NodeVectors& b) { return a.cwiseProduct(b).sum(); }

/// The least-squares problem min |β e₁ − H y| of an upper Hessenberg matrix that grows by columns,
/// made triangular by Givens' rotations.
class LeastSquares {
 public:
  LeastSquares(double beta, int most)
      : r_(Eigen::MatrixXd::Zero(most + 1, most)), g_(Eigen::VectorXd::Zero(most + 1)) {
    g_[0] = beta;
  }
  /// Takes column j of H, its entries 0 … j + 1.
  void add_column(int j, Eigen::VectorXd h) {
    for (int i = 0; i < j; ++i) h.applyOnTheLeft(i, i + 1, rotations_[static_cast<std::size_t>(i)]);
    Eigen::JacobiRotation<double> rotation;
    rotation.makeGivens(h[j], h[j + 1]);
    rotation = rotation.adjoint();
    h.applyOnTheLeft(j, j + 1, rotation);
    g_.applyOnTheLeft(j, j + 1, rotation);
    r_.col(j).head(j + 1) = h.head(j + 1);
    rotations_.push_back(rotation);
  }
  /// Of the columns so far.
  [[nodiscard]] double residual() const {
    return std::abs(g_[static_cast<Index>(rotations_.size())]);
  }
  [[nodiscard]] Eigen::VectorXd solution() const {
    const auto n = static_cast<Index>(rotations_.size());
    return r_.topLeftCorner(n, n).triangularView<Eigen::Upper>().solve(g_.head(n));
  }

 private:
  Eigen::MatrixXd r_;
  Eigen::VectorXd g_;
  std::vector<Eigen::JacobiRotation<double>> rotations_;
};

}  // namespace

KrylovSolution FlexibleGmres::solve(const NodeVectors& b, const KrylovLimits& limits,
                                    NodeVectors& x) const {
  const double beta = b.norm();
  if (!(beta > 0)) return {};
  std::vector<NodeVectors> v{b / beta}, z{x / beta};
  LeastSquares system(beta, limits.vectors);
  for (int j = 0; j < limits.vectors; ++j) {
    NodeVectors w;
    if (!a_(z[static_cast<std::size_t>(j)], w) || !w.allFinite()) return {};
    Eigen::VectorXd h = Eigen::VectorXd::Zero(limits.vectors + 1);
    for (int i = 0; i <= j; ++i) {  // modified Gram–Schmidt
      const NodeVectors& v_i = v[static_cast<std::size_t>(i)];
      h[i] = dot(w, v_i);
      w -= h[i] * v_i;
    }
    h[j + 1] = w.norm();
    system.add_column(j, h);
    const bool is_last = system.residual() <= limits.tolerance * beta || !(h[j + 1] > 0);
    if (is_last || j + 1 == limits.vectors) break;
    v.emplace_back(w / h[j + 1]);
    z.emplace_back();
    if (!inverse_p_(v.back(), z.back())) return {};
  }
  const Eigen::VectorXd y = system.solution();
  if (!y.allFinite()) return {};
  x.setZero();
  for (Index j = 0; j < y.size(); ++j) x += y[j] * z[static_cast<std::size_t>(j)];
  return {static_cast<int>(y.size()), system.residual() / beta};
}

}  // namespace deform
