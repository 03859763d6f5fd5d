// Flexible GMRES against a dense factorisation.
#include "solve/matrix/flexible_gmres.h"

#include <cmath>
#include <limits>
#include <random>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <gtest/gtest.h>

namespace deform {
namespace {

constexpr Index kNodes = 12;

NodeVectors from(const Eigen::VectorXd& x) { return x.reshaped(kNodes, 3); }
Eigen::VectorXd column(const NodeVectors& x) { return x.reshaped(); }

NodeVectors random_vectors(unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> number(-1, 1);
  return NodeVectors::NullaryExpr(kNodes, 3, [&] { return number(random); });
}

/// A = S + N: S symmetric positive definite, N a part as large that is not symmetric.
class FlexibleGmresTest : public ::testing::Test {
 protected:
  FlexibleGmresTest() {
    std::mt19937 random(7);
    std::normal_distribution<double> number;
    const auto draw = [&] { return number(random); };
    const Eigen::MatrixXd b = Eigen::MatrixXd::NullaryExpr(3 * kNodes, 3 * kNodes, draw);
    symmetric_ = b * b.transpose() + Eigen::MatrixXd::Identity(3 * kNodes, 3 * kNodes);
    a_ = symmetric_ + Eigen::MatrixXd::NullaryExpr(3 * kNodes, 3 * kNodes, draw);
  }
  /// With P = S, whose inverse is off by a part of itself that is never the same.
  KrylovSolution solve(const NodeVectors& b, const KrylovLimits& limits, NodeVectors& x,
                       double noise = 0) {
    const auto multiply = [this](const NodeVectors& in, NodeVectors& out) {
      out = from(a_ * column(in));
      return true;
    };
    const auto precondition = [&](const NodeVectors& in, NodeVectors& out) {
      const double size = (out = preconditioned(in)).norm();
      out += noise * size * random_vectors(++calls_).normalized();
      return true;
    };
    return gmres_.solve(multiply, precondition, b, limits, x);
  }
  [[nodiscard]] NodeVectors preconditioned(const NodeVectors& in) const {
    return from(symmetric_.llt().solve(column(in)));
  }
  [[nodiscard]] double residual(const NodeVectors& b, const NodeVectors& x) const {
    return (column(b) - a_ * column(x)).norm() / b.norm();
  }

  Eigen::MatrixXd a_, symmetric_;
  FlexibleGmres gmres_;
  unsigned calls_ = 0;
};

TEST_F(FlexibleGmresTest, SolvesAsAFactorisationDoes) {
  const NodeVectors b = random_vectors(1);
  NodeVectors x = preconditioned(b);
  const KrylovSolution found = solve(b, {.tolerance = 1e-12, .vectors = 36}, x);
  EXPECT_GT(found.vectors, 1);
  EXPECT_LE(found.residual, 1e-12);
  const Eigen::VectorXd right = a_.partialPivLu().solve(column(b));
  EXPECT_LE((column(x) - right).norm(), 1e-9 * right.norm());
}

TEST_F(FlexibleGmresTest, KnowsTheResidualItLeavesThoughThePreconditionerChanges) {
  const NodeVectors b = random_vectors(2);
  for (const int vectors : {1, 3, 8, 20}) {
    NodeVectors x = preconditioned(b);
    const KrylovSolution found = solve(b, {.tolerance = 0, .vectors = vectors}, x, 0.1);
    EXPECT_EQ(found.vectors, vectors);
    EXPECT_NEAR(found.residual, residual(b, x), 1e-12);
    EXPECT_LT(found.residual, 1);
  }
}

TEST_F(FlexibleGmresTest, TakesOneVectorWhereThePreconditionerIsTheMatrix) {
  a_ = symmetric_;
  const NodeVectors b = random_vectors(3);
  NodeVectors x = preconditioned(b);
  const NodeVectors before = x;
  const KrylovSolution found = solve(b, {.tolerance = 1e-8}, x);
  EXPECT_EQ(found.vectors, 1);
  EXPECT_LE((x - before).norm(), 1e-8 * before.norm());
  EXPECT_EQ(calls_, 0U);
}

TEST_F(FlexibleGmresTest, LeavesTheGuessWhereThereIsNoProduct) {
  const NodeVectors b = random_vectors(4);
  const NodeVectors guess = preconditioned(b);
  for (const bool is_finite : {true, false}) {
    const auto multiply = [&](const NodeVectors& in, NodeVectors& out) {
      out = in * std::numeric_limits<double>::quiet_NaN();
      return !is_finite;
    };
    const auto precondition = [](const NodeVectors&, NodeVectors&) { return true; };
    NodeVectors x = guess;
    EXPECT_EQ(gmres_.solve(multiply, precondition, b, {}, x).vectors, 0);
    EXPECT_EQ(x, guess);
  }
}

}  // namespace
}  // namespace deform
