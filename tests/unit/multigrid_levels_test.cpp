/// Matrices of multigrid against dense ones: products by quads of rows, coarser matrices.
#include <memory>
#include <random>
#include <set>

#include <Eigen/Core>
#include <gtest/gtest.h>

#include "multigrid/galerkin.h"

namespace multigrid {
namespace {

/// Neighbours that a node has, itself among them; symmetric.
struct Neighbours {
  std::string name;
  Index nodes;
  bool (*are)(Index a, Index b);
};
std::ostream& operator<<(std::ostream& out, const Neighbours& n) { return out << n.name; }

/// A grid of lines of 7 nodes, with those at most two lines and two columns away.
bool on_grid(Index a, Index b) {
  return std::abs(a / 7 - b / 7) <= 2 && std::abs(a % 7 - b % 7) <= 2;
}
bool on_band(Index a, Index b) { return std::abs(a - b) <= 3; }
bool on_ring(Index a, Index b) { return on_band(a, b) || std::abs(a - b) >= 41 - 2; }
bool scattered(Index a, Index b) { return a == b || (7 * (a + b) + a * b) % 5 == 0; }

Pattern pattern_of(const Neighbours& n) {
  Pattern p;
  p.nodes = n.nodes;
  for (Index a = 0; a < n.nodes; ++a) {
    for (Index b = 0; b < n.nodes; ++b)
      if (n.are(a, b)) p.column.push_back(static_cast<std::int32_t>(b));
    p.begin.push_back(static_cast<std::int32_t>(p.column.size()));
  }
  return p;
}

/// Each coarse node is every other fine one; between two lies their mean.
deform::Prolongation every_other(Index nodes) {
  deform::Prolongation p;
  p.coarse = (nodes + 1) / 2;
  for (Index a = 0; a < nodes; ++a) {
    const auto c = static_cast<std::int32_t>(a / 2);
    const bool is_between = a % 2 == 1 && c + 1 < p.coarse;
    p.node.push_back(c);
    p.weight.push_back(is_between ? 0.5 : 1);
    if (is_between) {
      p.node.push_back(c + 1);
      p.weight.push_back(0.5);
    }
    p.begin.push_back(static_cast<std::int32_t>(p.node.size()));
  }
  return p;
}

/// As a matrix for three components a node.
Eigen::MatrixXd dense(const deform::Prolongation& p, Index nodes) {
  Eigen::MatrixXd m = Eigen::MatrixXd::Zero(3 * nodes, 3 * p.coarse);
  for (Index a = 0; a < nodes; ++a)
    for (auto q = static_cast<std::size_t>(p.begin[static_cast<std::size_t>(a)]);
         q < static_cast<std::size_t>(p.begin[static_cast<std::size_t>(a) + 1]); ++q)
      for (Index c = 0; c < 3; ++c) m(3 * a + c, Index{3} * p.node[q] + c) = p.weight[q];
  return m;
}

template <class Entry>
Eigen::Matrix3d block_at(const Level<Entry>& level, std::int32_t place) {
  const float* value = level.value.data() + Entry::start(place);
  if constexpr (Entry::kColumns == 1)
    return static_cast<double>(*value) * Eigen::Matrix3d::Identity();
  Eigen::Matrix3d block;
  for (Index i = 0; i < 3; ++i)
    for (Index j = 0; j < 3; ++j)
      block(i, j) = static_cast<double>(value[Index{Entry::kStride} * j + i]);
  return block;
}

template <class Entry>
Eigen::MatrixXd dense(const Level<Entry>& level) {
  const Pattern& p = level.pattern;
  Eigen::MatrixXd m = Eigen::MatrixXd::Zero(3 * p.nodes, 3 * p.nodes);
  for (Index a = 0; a < p.nodes; ++a)
    for (auto k = p.begin[static_cast<std::size_t>(a)];
         k < p.begin[static_cast<std::size_t>(a) + 1]; ++k)
      m.block<3, 3>(3 * a, Index{3} * p.column[static_cast<std::size_t>(k)]) =
          block_at(level, level.quads.place(a, k));
  return m;
}

class Levels : public testing::TestWithParam<Neighbours> {
 protected:
  Levels() {
    blocks_.prepare(pattern_of(GetParam()), {});
    scalars_.prepare(pattern_of(GetParam()), {});
    fill_scalars();
    fill_blocks();
  }

  double some() { return uniform_(random_); }
  Index nodes() const { return GetParam().nodes; }

  /// The upper half as Newton's method makes it; both triangles.
  void fill_blocks() {
    const Pattern& p = blocks_.pattern;
    matrix_ = Eigen::MatrixXd::Zero(3 * nodes(), 3 * nodes());
    for (Index a = 0; a < nodes(); ++a) {
      std::vector<double> row;
      std::vector<std::int32_t> upper, lower;
      for (auto k = p.begin[static_cast<std::size_t>(a)];
           k < p.begin[static_cast<std::size_t>(a) + 1]; ++k) {
        const Index b = p.column[static_cast<std::size_t>(k)];
        if (b < a) continue;
        Eigen::Matrix3d block = Eigen::Matrix3d::NullaryExpr([&] { return some(); });
        if (a == b) block = (block + block.transpose()).eval();
        matrix_.block<3, 3>(3 * a, 3 * b) = block;
        matrix_.block<3, 3>(3 * b, 3 * a) = block.transpose();
        for (Index i = 0; i < 9; ++i) row.push_back(block(i / 3, i % 3));
        upper.push_back(blocks_.place(a, b));
        lower.push_back(blocks_.place(b, a));
      }
      write_blocks(row.data(), upper.data(), lower.data(), static_cast<Index>(upper.size()),
                   blocks_.value.data());
    }
  }
  void fill_scalars() {
    const Pattern& p = scalars_.pattern;
    for (Index a = 0; a < nodes(); ++a)
      for (auto k = p.begin[static_cast<std::size_t>(a)];
           k < p.begin[static_cast<std::size_t>(a) + 1]; ++k)
        scalars_.value[static_cast<std::size_t>(scalars_.quads.place(a, k))] =
            static_cast<float>(some());
  }

  template <class Entry>
  void expect_product(const Level<Entry>& level) {
    LaneVector y, product;
    y.assign(nodes());
    product.assign(nodes());
    Eigen::VectorXd expected(3 * nodes());
    for (Index a = 0; a < nodes(); ++a)
      for (Index c = 0; c < 3; ++c)
        expected[3 * a + c] = static_cast<double>(y(a, c) = static_cast<float>(some()));
    expected = (dense(level) * expected).eval();
    level.multiply(y, 0, y.quads(), product);
    for (Index a = 0; a < nodes(); ++a) {
      for (Index c = 0; c < 3; ++c)
        EXPECT_NEAR(static_cast<double>(product(a, c)), expected[3 * a + c], 1e-5) << a;
      EXPECT_EQ(product(a, 3), 0) << a;
    }
  }
  template <class Entry>
  void expect_coarser(const Level<Entry>& fine) {
    const deform::Prolongation p = every_other(nodes());
    const Galerkin galerkin(fine.pattern, fine.quads, p);
    Level<Entry> coarse;
    coarse.prepare(galerkin.coarse(), {});
    galerkin.multiply(fine, coarse);
    const Eigen::MatrixXd interpolation = dense(p, nodes());
    const Eigen::MatrixXd expected = interpolation.transpose() * dense(fine) * interpolation;
    EXPECT_LT((dense(coarse) - expected).cwiseAbs().maxCoeff(), 1e-5);
  }

  Level<Block> blocks_;
  Level<Scalar> scalars_;
  Eigen::MatrixXd matrix_;  // of the blocks

 private:
  std::mt19937 random_{3};
  std::uniform_real_distribution<double> uniform_{-1, 1};
};

TEST_P(Levels, HaveBothTrianglesOfBlocks) {
  EXPECT_LT((dense(blocks_) - matrix_).cwiseAbs().maxCoeff(), 1e-6);
}
TEST_P(Levels, MultiplyAsDenseMatrices) {
  expect_product(blocks_);
  expect_product(scalars_);
}
TEST_P(Levels, AreInterpolatedToCoarserOnes) {
  expect_coarser(blocks_);
  expect_coarser(scalars_);
}

INSTANTIATE_TEST_SUITE_P(Patterns, Levels,
                         testing::Values(Neighbours{"grid", 63, on_grid},
                                         Neighbours{"band", 41, on_band},
                                         Neighbours{"ring", 41, on_ring},
                                         Neighbours{"scattered", 38, scattered},
                                         Neighbours{"tiny", 3, on_band}));

}  // namespace
}  // namespace multigrid
