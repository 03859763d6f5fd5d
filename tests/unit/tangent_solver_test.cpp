/// Tangents solved to a tolerance: rows that go to a solver, and what is done when it does not end.
#include "solve/matrix/tangent_solver.h"

#include <gtest/gtest.h>

#include "unit/support/builtin.h"

namespace deform {
namespace {

/// Takes whatever it is given, keeps sums of it, and never ends.
class Endless final : public LinearSolver, public BlockSolver {
 public:
  [[nodiscard]] double suitability(const MatrixTraits& /*traits*/) const override { return 0; }
  void analyse(const SparseMatrix& /*a*/, const MatrixTraits& /*traits*/) override {}
  [[nodiscard]] Factorisation factor(const SparseMatrix& /*a*/) override { return "endless"; }
  void solve(const Eigen::Ref<const Eigen::MatrixXd>& /*b*/,
             Eigen::Ref<Eigen::MatrixXd> /*x*/) override {}
  [[nodiscard]] BlockSolver* blocks() override { return this; }

  [[nodiscard]] double block_suitability(Index /*nodes*/) const override { return 100; }
  void analyse(const BlockMatrix& /*pattern*/, const std::vector<std::uint8_t>& /*held*/) override {
  }
  void put(const BlockRows& rows) override { nodes += rows.size; }
  void factor(const NodeValues& d, const NodeBlocks& /*blocks*/, bool /*renew*/) override {
    diagonal = d;
  }
  [[nodiscard]] Outcome solve(const NodeVectors& /*b*/, double /*tolerance*/,
                              NodeVectors& /*x*/) override {
    return Outcome::unfinished;
  }
  [[nodiscard]] long iterations() const override { return 7; }

  Index nodes = 0;
  NodeValues diagonal;
};

/// A chain of nodes, each linked to the next and held a little.
BlockMatrix chain(Index nodes) {
  BlockMatrix k;
  k.nodes = nodes;
  for (Index a = 0; a < nodes; ++a) {
    k.column.push_back(static_cast<std::int32_t>(a));
    if (a + 1 < nodes) k.column.push_back(static_cast<std::int32_t>(a + 1));
    k.row_begin.push_back(static_cast<std::int32_t>(k.column.size()));
  }
  k.value.assign(9 * k.column.size(), 0.0);
  for (Index a = 0; a < nodes; ++a) {
    k.block(a, a) = 3 * Eigen::Matrix3d::Identity();
    if (a + 1 < nodes) k.block(a, a + 1) = -Eigen::Matrix3d::Identity();
  }
  return k;
}

/// The rows lack some of the diagonal; the factorisation that takes over has all of it, once.
TEST(TangentSolver, HandsOverTheWholeMatrix) {
  constexpr Index kNodes = 6;
  const BlockMatrix k = chain(kNodes);
  const auto endless = std::make_shared<Endless>();
  const ReductionMap map{Reduction(kNodes)};
  TangentSolver solver(
      map, k, {}, MakeSolvers([&] {
        return std::vector<Named<LinearSolver>>{
            {"endless", "solver/endless", endless},
            {"cholmod", "solver/cholmod", test::make_builtin<LinearSolver>("cholmod")}};
      }),
      [&]() -> const BlockMatrix& { return k; });
  ASSERT_TRUE(solver.takes_rows());
  solver.put(k);
  EXPECT_EQ(endless->nodes, kNodes);
  const NodeValues d = NodeValues::Constant(kNodes, 0.5), beside = NodeValues::Constant(kNodes, 2);
  ASSERT_EQ(solver.factor_to_tolerance(d, beside, {}, true), "");
  EXPECT_EQ(endless->diagonal, beside);
  const NodeVectors b = NodeVectors::Ones(kNodes, 3);
  NodeVectors x, product;
  ASSERT_EQ(solver.solve_to_tolerance(0.1, false, b, x), "");
  EXPECT_EQ(solver.iterations(), 7);
  k.multiply(x, product);
  product += d.asDiagonal() * x;
  EXPECT_LT((product - b).cwiseAbs().maxCoeff(), 1e-12);
}

/// Where there is no factorisation, that is a reason for Newton's method, not the end.
TEST(TangentSolver, SaysWhyWhereItIsAlone) {
  const BlockMatrix k = chain(4);
  const ReductionMap map{Reduction(4)};
  const auto endless = std::make_shared<Endless>();
  TangentSolver solver(
      map, k, {}, MakeSolvers([&] {
        return std::vector<Named<LinearSolver>>{{"endless", "solver/endless", endless}};
      }),
      [&]() -> const BlockMatrix& { return k; });
  ASSERT_TRUE(solver.takes_rows());
  solver.put(k);
  const NodeValues d = NodeValues::Ones(4);
  ASSERT_EQ(solver.factor_to_tolerance(d, d, {}, true), "");
  NodeVectors x;
  EXPECT_NE(solver.solve_to_tolerance(0.1, false, NodeVectors::Ones(4, 3), x).find("endless"),
            std::string::npos);
}

}  // namespace
}  // namespace deform
