// Blocks between any two nodes, beside those of a matrix' own pattern.
#include "solve/matrix/growing_pattern.h"

#include <vector>

#include <gtest/gtest.h>

#include "solve/assembly/block_pattern.h"

namespace {
using namespace deform;

/// A chain of five nodes.
BlockMatrix chain() {
  BlockPatternBuilder builder(5);
  for (Index a = 0; a + 1 < 5; ++a) builder.add(a, a + 1);
  return builder.build();
}

/// Row a of the chain: block (a, b) is filled with 10 a + b.
std::vector<double> row_of(const BlockMatrix& k, Index a) {
  std::vector<double> row;
  for (const std::int32_t b : k.columns(a))
    row.insert(row.end(), 9, static_cast<double>(10 * a + b));
  return row;
}

void store_all(const BlockMatrix& base, GrowingPattern& pattern) {
  for (Index a = 0; a < base.nodes; ++a) {
    const std::vector<double> row = row_of(base, a);
    EXPECT_TRUE(pattern.store({a, 1, row.data(), 1}));
  }
}

TEST(GrowingPattern, KeepsWhatItHas) {
  const BlockMatrix base = chain();
  GrowingPattern pattern(base);
  pattern.matrix.value.resize(9 * base.column.size());
  store_all(base, pattern);
  const std::vector<BlockEntry> known{{1, 2, Eigen::Matrix3d::Identity()},
                                      {3, 3, Eigen::Matrix3d::Identity()}};
  EXPECT_FALSE(pattern.grow(known));
  EXPECT_EQ(pattern.matrix.column, base.column);
}

TEST(GrowingPattern, GainsBlocksAndTakesRowsOfItsBase) {
  const BlockMatrix base = chain();
  GrowingPattern pattern(base);
  pattern.matrix.value.resize(9 * base.column.size());
  store_all(base, pattern);
  Eigen::Matrix3d block = Eigen::Matrix3d::Zero();
  block(0, 2) = 7;
  const std::vector<BlockEntry> far{{4, 0, block}, {1, 3, block}};
  EXPECT_TRUE(pattern.grow(far));
  for (const BlockEntry& e : far) pattern.add(e);
  EXPECT_EQ(pattern.matrix.block(0, 4)(2, 0), 7);  // transposed
  EXPECT_EQ(pattern.matrix.block(1, 3)(0, 2), 7);
  EXPECT_EQ(pattern.matrix.block(2, 3)(1, 1), 23);  // as it was
  store_all(base, pattern);
  EXPECT_TRUE(pattern.matrix.block(0, 4).isZero(0));
  for (Index a = 0; a < base.nodes; ++a)
    for (const std::int32_t b : base.columns(a))
      EXPECT_TRUE(pattern.matrix.block(a, b).isConstant(static_cast<double>(10 * a + b)));
  EXPECT_FALSE(pattern.grow(far));
  EXPECT_FALSE(pattern.grow({}));
}

TEST(GrowingPattern, DropsWhatNobodyAsksForWhenItChanges) {
  const BlockMatrix base = chain();
  GrowingPattern pattern(base);
  const std::vector<BlockEntry> old{{0, 4}}, other{{0, 3}}, third{{1, 4}};
  EXPECT_TRUE(pattern.grow(old));
  EXPECT_TRUE(pattern.grow(other));
  EXPECT_EQ(pattern.matrix.column.size(), base.column.size() + 2);
  for (int i = 0; i < 100; ++i) EXPECT_FALSE(pattern.grow(other));
  EXPECT_TRUE(pattern.grow(third));
  EXPECT_EQ(pattern.matrix.column.size(), base.column.size() + 2);
  EXPECT_TRUE(pattern.grow(old));
}

TEST(GrowingPattern, RefusesNodesThatAreNone) {
  const BlockMatrix base = chain();
  GrowingPattern pattern(base);
  EXPECT_THROW((void)pattern.grow(std::vector<BlockEntry>{{0, 5}}), std::out_of_range);
  EXPECT_THROW((void)pattern.grow(std::vector<BlockEntry>{{-1, 2}}), std::out_of_range);
}

}  // namespace
