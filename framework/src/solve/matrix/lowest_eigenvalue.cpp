#include "solve/matrix/lowest_eigenvalue.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <random>
#include <vector>

#include <Eigen/Eigenvalues>
#include <Eigen/SparseCholesky>

#include "deform/error.h"

namespace deform {
namespace {

using Columns = Eigen::SparseMatrix<double, Eigen::ColMajor, std::int32_t>;

constexpr int kMostVectors = 60;
constexpr double kConverged = 1e-10;

/// K − σM = P L D Lᵀ Pᵀ without pivoting: the signs of D count the eigenvalues below σ.
class Shifted {
 public:
  Shifted(const SparseMatrix& k, const Eigen::VectorXd& m) : k_(k.size, k.size), m_(m) {
    k_ = Eigen::Map<const Columns>(k.size, k.size, static_cast<Index>(k.value.size()),
                                   k.row_begin.data(), k.column.data(), k.value.data());
    ldlt_.analyzePattern(k_);
  }

  /// The number of eigenvalues below σ; moves σ a little where K − σM is singular to rounding.
  Index factor(double& sigma) {
    for (int attempt = 0; attempt < 8; ++attempt) {
      Columns shifted = k_;
      for (Index i = 0; i < shifted.rows(); ++i) shifted.coeffRef(i, i) -= sigma * m_[i];
      ldlt_.factorize(shifted);
      if (ldlt_.info() == Eigen::Success && ldlt_.vectorD().allFinite() &&
          (ldlt_.vectorD().array() != 0).all())
        return (ldlt_.vectorD().array() < 0).count();
      sigma -= 1e-9 * scale();
    }
    throw Error(ExitCode::diverged, "the tangent cannot be factorised for its eigenvalues");
  }
  [[nodiscard]] Eigen::VectorXd solve(const Eigen::VectorXd& b) const { return ldlt_.solve(b); }
  /// The size of the eigenvalues at large.
  [[nodiscard]] double scale() const {
    return (k_.diagonal().cwiseAbs().array() / m_.array()).mean();
  }

 private:
  Columns k_;
  Eigen::VectorXd m_;
  Eigen::SimplicialLDLT<Columns, Eigen::Lower, Eigen::AMDOrdering<std::int32_t>> ldlt_;
};

struct Mode {
  double value;
  Eigen::VectorXd vector;
};

/// The eigenvalue of (K − σM)⁻¹ M that is largest in size, as one of K x = λ M x: the nearest to σ.
/// Lanczos with full orthogonalisation in the product of M.
Mode nearest(const Shifted& a, const Eigen::VectorXd& m, double sigma) {
  const Index n = m.size();
  std::minstd_rand random(1);
  std::uniform_real_distribution<double> uniform(-1, 1);
  Eigen::VectorXd q = Eigen::VectorXd::NullaryExpr(n, [&] { return uniform(random); });
  std::vector<Eigen::VectorXd> basis;
  std::vector<double> alpha, beta;
  Mode best{sigma, q};
  double last = 0;
  for (int k = 0; k < std::min<Index>(kMostVectors, n); ++k) {
    q /= std::sqrt(q.dot(m.cwiseProduct(q)));
    basis.push_back(q);
    Eigen::VectorXd w = a.solve(m.cwiseProduct(q));
    alpha.push_back(q.dot(m.cwiseProduct(w)));
    for (int pass = 0; pass < 2; ++pass)
      for (const Eigen::VectorXd& b : basis) w -= b.dot(m.cwiseProduct(w)) * b;

    const auto size = static_cast<Index>(alpha.size());
    Eigen::MatrixXd t = Eigen::MatrixXd::Zero(size, size);
    for (Index i = 0; i < size; ++i) {
      t(i, i) = alpha[static_cast<std::size_t>(i)];
      if (i > 0) t(i, i - 1) = t(i - 1, i) = beta[static_cast<std::size_t>(i - 1)];
    }
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> spectrum(t);
    Index at = 0;
    spectrum.eigenvalues().cwiseAbs().maxCoeff(&at);
    const double theta = spectrum.eigenvalues()[at];
    const double length = std::sqrt(w.dot(m.cwiseProduct(w)));
    best.value = sigma + 1 / theta;
    const bool is_done = std::abs(theta - last) <= kConverged * std::abs(theta) ||
                         length <= kConverged * std::abs(theta);
    if (is_done || size == std::min<Index>(kMostVectors, n)) {
      best.vector = Eigen::VectorXd::Zero(n);
      for (Index i = 0; i < size; ++i)
        best.vector += spectrum.eigenvectors()(i, at) * basis[static_cast<std::size_t>(i)];
      break;
    }
    last = theta;
    beta.push_back(length);
    q = w;
  }
  return best;
}

}  // namespace

LowestEigenvalue lowest_eigenvalue(const SparseMatrix& k, const Eigen::VectorXd& m) {
  if (k.size == 0) return {};
  Shifted shifted(k, m);
  double sigma = 0;
  const Index negative = shifted.factor(sigma);
  Mode lowest = nearest(shifted, m, sigma);
  // With negative ones about, the nearest to 0 need not be the lowest: from below all of them.
  double reach = std::max(std::abs(lowest.value), 1e-12 * shifted.scale());
  while (negative > 0) {
    sigma = -2 * reach;
    if (shifted.factor(sigma) == 0) {
      lowest = nearest(shifted, m, sigma);
      break;
    }
    reach *= 4;
  }
  return {lowest.value, lowest.vector, negative};
}

}  // namespace deform
