/// Matrices of multigrid against dense ones: products by strips of rows, coarser matrices,
/// interpolation.
#include <memory>
#include <random>

#include <Eigen/Core>
#include <Eigen/LU>
#include <gtest/gtest.h>

#include "multigrid/galerkin.h"
#include "multigrid/level.h"

namespace multigrid {
namespace {

/// Neighbours that a node has, itself among them; symmetric.
struct Neighbours {
  std::string name;
  Index nodes;
  bool (*are)(Index a, Index b);
};
std::ostream& operator<<(std::ostream& out, const Neighbours& n) { return out << n.name; }

bool within_two(Index a, Index b, Index columns) {
  return std::abs(a / columns - b / columns) <= 2 && std::abs(a % columns - b % columns) <= 2;
}
/// Grids of lines of 7 nodes and of 67, with those at most two lines and two columns away.
bool on_grid(Index a, Index b) { return within_two(a, b, 7); }
bool on_wide_grid(Index a, Index b) { return within_two(a, b, 67); }
bool on_band(Index a, Index b) { return std::abs(a - b) <= 3; }
bool on_ring(Index a, Index b) { return on_band(a, b) || std::abs(a - b) >= 41 - 2; }
bool scattered(Index a, Index b) { return a == b || (7 * (a + b) + a * b) % 5 == 0; }

Pattern pattern_of(const Neighbours& n) {
  Pattern p;
  p.nodes = n.nodes;
  for (Index a = 0; a < n.nodes; ++a) {
    for (Index b = a; b < n.nodes; ++b)
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

/// Calls visit(a, b, place) for the entries of a level's upper half.
template <class Entry, class Visit>
void each_entry(const Level<Entry>& level, const Visit& visit) {
  for (Index a = 0; a < level.nodes(); ++a)
    for (const std::int32_t distance : level.strips.distances(level.strips.strip_of(a)))
      if (a + distance < level.nodes())
        visit(a, a + distance, level.strips.place(a, distance, Entry::kNumbers));
}

template <class Entry>
Eigen::MatrixXd dense(const Level<Entry>& level) {
  Eigen::MatrixXd m = Eigen::MatrixXd::Zero(3 * level.nodes(), 3 * level.nodes());
  each_entry(level, [&](Index a, Index b, const Place& at) {
    const auto number = [&](Index q) {
      return static_cast<double>(level.value[static_cast<std::size_t>(at.first + q * at.stride)]);
    };
    Eigen::Matrix3d block = number(0) * Eigen::Matrix3d::Identity();
    if constexpr (Entry::kNumbers == 9)
      for (Index q = 0; q < 9; ++q) block(q / 3, q % 3) = number(q);
    m.block<3, 3>(3 * a, 3 * b) = block;
    m.block<3, 3>(3 * b, 3 * a) = block.transpose();
  });
  return m;
}

/// (3N) all components of a node, then those of the next.
Eigen::VectorXd dense(const Field<float>& y) {
  Eigen::VectorXd v(3 * y.nodes());
  for (Index a = 0; a < y.nodes(); ++a)
    for (Index c = 0; c < 3; ++c) v[3 * a + c] = static_cast<double>(y(a, c));
  return v;
}

class Levels : public testing::TestWithParam<Neighbours> {
 protected:
  Levels() {
    blocks_.prepare(pattern_of(GetParam()), {});
    scalars_.prepare(pattern_of(GetParam()), {});
    fill(blocks_);
    fill(scalars_);
  }

  double some() { return uniform_(random_); }
  [[nodiscard]] Index nodes() const { return GetParam().nodes; }
  Field<float> some_field() {
    Field<float> y;
    blocks_.assign(y);
    for (Index a = 0; a < nodes(); ++a)
      for (Index c = 0; c < 3; ++c) y(a, c) = static_cast<float>(some());
    return y;
  }

  /// Of the pattern's entries alone: strips have zeros beside them. Diagonal blocks are symmetric.
  template <class Entry>
  void fill(Level<Entry>& level) {
    each_entry(level, [&](Index a, Index b, const Place& at) {
      if (!GetParam().are(a, b)) return;
      for (Index q = 0; q < Entry::kNumbers; ++q) {
        float& number = level.value[static_cast<std::size_t>(at.first + q * at.stride)];
        const Index mirrored = 3 * (q % 3) + q / 3;
        number = a == b && mirrored < q
                     ? level.value[static_cast<std::size_t>(at.first + mirrored * at.stride)]
                     : static_cast<float>(some());
      }
    });
  }

  template <class Entry>
  void expect_product(Level<Entry>& level) {
    const Field<float> y = some_field();
    Field<float> product;
    level.assign(product);
    const double square = level.multiply(y, product);
    const Eigen::VectorXd expected = dense(level) * dense(y);
    EXPECT_LT((dense(product) - expected).cwiseAbs().maxCoeff(), 1e-5);
    EXPECT_NEAR(square, dense(y).dot(expected), 1e-4);
  }

  /// Components in bits of some nodes, which neither move nor pull.
  template <class Entry>
  void expect_cuts(Level<Entry>& level, std::uint8_t components) {
    const std::vector<Held> held{{0, components}, {2, components}};
    Eigen::MatrixXd expected = dense(level);
    const std::vector<float> values = level.value;
    level.prepare(pattern_of(GetParam()), held);
    level.value = values;
    level.finish();
    for (const Held& h : held)
      for (Index c = 0; c < 3; ++c)
        if ((components >> c & 1) != 0) {
          expected.row(Index{3} * h.node + c).setZero();
          expected.col(Index{3} * h.node + c).setZero();
        }
    EXPECT_EQ(dense(level), expected);
  }

  template <class Entry>
  void expect_coarser(const Level<Entry>& fine) {
    const deform::Prolongation p = every_other(nodes());
    Galerkin galerkin(pattern_of(GetParam()), p);
    Level<Entry> coarse;
    coarse.prepare(galerkin.coarse(), {});
    galerkin.bind(fine.strips, coarse.strips, Entry::kNumbers);
    galerkin.multiply<Entry>(fine.value, coarse.value);
    const Eigen::MatrixXd interpolation = dense(p, nodes());
    const Eigen::MatrixXd expected = interpolation.transpose() * dense(fine) * interpolation;
    EXPECT_LT((dense(coarse) - expected).cwiseAbs().maxCoeff(), 1e-5);
    expect_transfers(galerkin, coarse, interpolation);
  }
  template <class Entry>
  void expect_transfers(const Galerkin& galerkin, const Level<Entry>& coarse,
                        const Eigen::MatrixXd& interpolation) {
    Field<float> fine = some_field(), restricted;
    coarse.assign(restricted);
    galerkin.restrict_to(fine, restricted);
    EXPECT_LT((dense(restricted) - interpolation.transpose() * dense(fine)).cwiseAbs().maxCoeff(),
              1e-5);
    const Eigen::VectorXd expected = dense(fine) + interpolation * dense(restricted);
    for (const Runs::Task& task : galerkin.interpolation().tasks())
      galerkin.interpolation().multiply(task, restricted, fine, true);
    EXPECT_LT((dense(fine) - expected).cwiseAbs().maxCoeff(), 1e-5);
  }

  Level<Block> blocks_;
  Level<Scalar> scalars_;

 private:
  std::mt19937 random_{3};
  std::uniform_real_distribution<double> uniform_{-1, 1};
};

TEST_P(Levels, MultiplyAsDenseMatrices) {
  expect_product(blocks_);
  expect_product(scalars_);
}
TEST_P(Levels, LeaveOutWhatIsHeld) {
  expect_cuts(blocks_, 5);
  expect_cuts(scalars_, 7);
}
TEST_P(Levels, AreInterpolatedToCoarserOnes) {
  expect_coarser(blocks_);
  expect_coarser(scalars_);
}

/// x = ω D⁻¹ f for two right-hand sides of one matrix: D x is f but for a factor.
TEST_P(Levels, SmoothByTheInverseOfTheDiagonal) {
  const Eigen::MatrixXd a = dense(blocks_);
  for (Index i = 0; i < nodes(); ++i)  // definite
    for (Index c = 0; c < 3; ++c) {
      const Place at = blocks_.strips.place(i, 0, Block::kNumbers);
      blocks_.value[static_cast<std::size_t>(at.first + 4 * c * at.stride)] += 4;
    }
  blocks_.finish();
  blocks_.f = some_field();
  blocks_.start();
  Eigen::VectorXd product(3 * nodes());
  for (Index i = 0; i < nodes(); ++i)
    product.segment<3>(3 * i) = (a.block<3, 3>(3 * i, 3 * i) + 4 * Eigen::Matrix3d::Identity()) *
                                dense(blocks_.x).segment<3>(3 * i);
  const double omega = product[0] / dense(blocks_.f)[0];
  EXPECT_GT(omega, 0);
  EXPECT_LT((product - omega * dense(blocks_.f)).cwiseAbs().maxCoeff(), 1e-5);
}

INSTANTIATE_TEST_SUITE_P(
    Patterns, Levels,
    testing::Values(Neighbours{"grid", 63, on_grid}, Neighbours{"wide_grid", 335, on_wide_grid},
                    Neighbours{"band", 41, on_band}, Neighbours{"ring", 41, on_ring},
                    Neighbours{"scattered", 38, scattered}, Neighbours{"tiny", 3, on_band}));

/// Rows behind the first chunk get what those before give them.
TEST(Products, GoOnFromChunkToChunk) {
  const Index columns = 97, nodes = columns * 70;
  Pattern pattern;
  pattern.nodes = nodes;
  for (Index a = 0; a < nodes; ++a) {
    for (const Index b : {a, a + 1, a + columns})
      if (b < nodes && (b != a + 1 || b % columns != 0))
        pattern.column.push_back(static_cast<std::int32_t>(b));
    pattern.begin.push_back(static_cast<std::int32_t>(pattern.column.size()));
  }
  Level<Scalar> level;
  level.prepare(pattern, {});
  ASSERT_GT(level.strips.chunks().size(), 2U);
  EXPECT_EQ(level.strips.strips().size(), 70U);
  each_entry(level, [&](Index a, Index b, const Place& at) {
    const bool wraps = b == a + 1 && b % columns == 0;  // the strip has it for the other rows
    if (!wraps) level.value[static_cast<std::size_t>(at.first)] = a == b ? 4 : -1;
  });
  Field<float> y, product;
  level.assign(y);
  level.assign(product);
  for (Index a = 0; a < nodes; ++a) y(a, 1) = static_cast<float>(a % 11);
  (void)level.multiply(y, product);
  for (Index a = 0; a < nodes; ++a) {
    float expected = 4 * y(a, 1);
    if (a % columns > 0) expected -= y(a - 1, 1);
    if (a % columns + 1 < columns) expected -= y(a + 1, 1);
    if (a >= columns) expected -= y(a - columns, 1);
    if (a + columns < nodes) expected -= y(a + columns, 1);
    ASSERT_EQ(product(a, 1), expected) << a;
  }
}

}  // namespace
}  // namespace multigrid
