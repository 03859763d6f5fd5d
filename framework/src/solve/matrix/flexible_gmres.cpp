#include "solve/matrix/flexible_gmres.h"

#include <algorithm>
#include <cmath>
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

KrylovSolution FlexibleGmres::solve(const Operator& a, const Operator& inverse_p,
                                    const NodeVectors& b, const KrylovLimits& limits,
                                    NodeVectors& x) {
  const double beta = b.norm();
  if (!(beta > 0)) return {};
  const auto room = static_cast<std::size_t>(limits.vectors);
  v_.resize(std::max(v_.size(), room));
  z_.resize(v_.size());
  v_[0] = b / beta;
  z_[0] = x / beta;
  LeastSquares system(beta, limits.vectors);
  for (std::size_t j = 0;; ++j) {
    if (!a(z_[j], w_) || !w_.allFinite()) return {};
    Eigen::VectorXd h = Eigen::VectorXd::Zero(limits.vectors + 1);
    for (std::size_t i = 0; i <= j; ++i) {  // modified Gram–Schmidt
      const auto row = static_cast<Index>(i);
      h[row] = dot(w_, v_[i]);
      w_ -= h[row] * v_[i];
    }
    const double left = h[static_cast<Index>(j) + 1] = w_.norm();
    system.add_column(static_cast<int>(j), h);
    if (system.residual() <= limits.tolerance * beta || !(left > 0) || j + 1 == room) break;
    v_[j + 1] = w_ / left;
    if (!inverse_p(v_[j + 1], z_[j + 1])) return {};
  }
  const Eigen::VectorXd y = system.solution();
  if (!y.allFinite()) return {};
  x.setZero();
  for (Index j = 0; j < y.size(); ++j) x += y[j] * z_[static_cast<std::size_t>(j)];
  return {static_cast<int>(y.size()), system.residual() / beta};
}

}  // namespace deform
