/// Rows of tangents, made and moved side by side: as one by one.
#include "solve/assembly/tangent_rows.h"

#include <array>
#include <limits>
#include <random>

#include <Eigen/Core>
#include <gtest/gtest.h>

namespace deform {
namespace {

class SomeNumbers {
 public:
  std::vector<double> some_numbers(std::size_t size) {
    std::vector<double> numbers(size);
    for (double& x : numbers) x = uniform_(random_);
    return numbers;
  }

 private:
  std::mt19937 random_{7};
  std::uniform_real_distribution<double> uniform_{-1, 1};
};

class TangentRows : public SomeNumbers, public testing::TestWithParam<Index> {};
class TangentRowShapes : public SomeNumbers, public testing::TestWithParam<TangentShape> {};

/// Rows side by side, and where each is to go.
struct Moved {
  Moved(Index size, Index numbers, std::vector<double> there)
      : whole(std::move(there)), to(kRowLanes, nullptr) {
    for (Index k = 0; k < size; ++k) to[static_cast<std::size_t>(k)] = whole.data() + k * numbers;
  }
  std::vector<double> whole;
  std::vector<double*> to;
};

TEST_P(TangentRows, AreWholeWhereTheyAreMoved) {
  const Index size = GetParam();
  for (const Index numbers : {9, 18, 117})
    for (const bool adds : {false, true}) {
      const std::vector<double> rows = some_numbers(static_cast<std::size_t>(numbers * kRowLanes));
      const std::vector<double> before = some_numbers(static_cast<std::size_t>(numbers * size + 1));
      Moved moved(size, numbers, before);
      EXPECT_TRUE(store_rows(rows.data(), size, numbers, moved.to.data(), adds));
      for (Index k = 0; k < size; ++k)
        for (Index i = 0; i < numbers; ++i) {
          const auto at = static_cast<std::size_t>(k * numbers + i);
          const double row = rows[static_cast<std::size_t>(i * kRowLanes + k)];
          ASSERT_EQ(moved.whole[at], adds ? before[at] + row : row) << k << ", " << i;
        }
      EXPECT_EQ(moved.whole.back(), before.back()) << "written behind the last row";
    }
}

/// At each of the rows, first and last numbers among them.
TEST_P(TangentRows, WithSomethingNotFiniteAreFoundOut) {
  const Index size = GetParam(), numbers = 18;
  for (const double bad :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(),
        -std::numeric_limits<double>::infinity()})
    for (Index k = 0; k < size; ++k)
      for (const Index i : {Index{0}, Index{7}, numbers - 1}) {
        std::vector<double> rows = some_numbers(static_cast<std::size_t>(numbers * kRowLanes));
        rows[static_cast<std::size_t>(i * kRowLanes + k)] = bad;
        Moved moved(size, numbers, some_numbers(static_cast<std::size_t>(numbers * size)));
        EXPECT_FALSE(store_rows(rows.data(), size, numbers, moved.to.data(), false));
      }
}

INSTANTIATE_TEST_SUITE_P(Sizes, TangentRows, testing::Values(1, 3, 4, 5, 31, kRowLanes));

/// What is there may be what is not finite, or the sum.
TEST(TangentRow, WithSomethingNotFiniteIsFoundOut) {
  const std::vector<double> row(9, 1e308);
  std::vector<double> to(9, 1);
  EXPECT_TRUE(store_row(row.data(), 9, to.data(), true));
  to[4] = 1e308;
  EXPECT_FALSE(store_row(row.data(), 9, to.data(), true));
  EXPECT_TRUE(store_row(row.data(), 9, to.data(), false));
  to[8] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(store_row(row.data(), 9, to.data(), true));
  EXPECT_TRUE(store_row(row.data(), 9, to.data(), false));
}

/// Two samples, three parts, three blocks, of which one has none.
TangentPlan some_plan() {
  TangentPlan plan;
  plan.left = {{0, false, 0.5}, {1, true, -2}, {1, false, 3}, {0, true, 1.5}};
  plan.parts = {{0, 2}, {0, 3}, {1, 4}};
  plan.right = {{0, 0.25}, {1, -1}, {2, 4}, {0, 3}, {2, -0.5}};
  plan.right_end = {3, 3, 5};
  plan.samples = 2;
  return plan;
}
constexpr Index kBlocks = 2, kNumbers = 27;  // of a sample; of a row

/// Numbers that lie further on by a lane belong to the next row.
TEST_P(TangentRowShapes, SideBySideHaveTheBitsOfOneByOne) {
  const TangentPlan plan = some_plan();
  const std::vector<double> h = some_numbers(2 * 9 * kBlocks * kSampleLanes);
  const std::vector<std::uint32_t> places = {3, 9 * kBlocks * kSampleLanes};
  std::vector<double> room(room_for(plan));
  for (const bool adds : {false, true}) {
    const std::vector<double> before = some_numbers(kNumbers * kRowLanes);
    std::vector<double> rows = before;
    EXPECT_TRUE(make_rows(plan, {h.data(), places.data(), GetParam(), kBlocks}, adds, kRowLanes,
                          room.data(), rows.data()));
    for (std::uint32_t k = 0; k < kRowLanes; ++k) {
      std::vector<double> row(kNumbers);
      for (std::size_t i = 0; i < row.size(); ++i) row[i] = before[i * kRowLanes + k];
      const std::vector<std::uint32_t> of_row = {places[0] + k, places[1] + k};
      EXPECT_TRUE(make_row(plan, {h.data(), of_row.data(), GetParam(), kBlocks}, adds, room.data(),
                           row.data()));
      for (std::size_t i = 0; i < row.size(); ++i)
        ASSERT_EQ(rows[i * kRowLanes + k], row[i]) << k << ", " << i;
    }
  }
}
INSTANTIATE_TEST_SUITE_P(All, TangentRowShapes,
                         testing::Values(TangentShape::blocks, TangentShape::normal,
                                         TangentShape::identity));

/// Found out in rows, not in lanes behind them.
TEST_P(TangentRowShapes, WithSomethingNotFiniteAreFoundOut) {
  const TangentPlan plan = some_plan();
  const std::vector<std::uint32_t> places = {0, 9 * kBlocks * kSampleLanes};
  std::vector<double> room(room_for(plan)), rows(kNumbers * kRowLanes);
  constexpr Index kSize = 13;
  for (const std::size_t lane : {0, 7, 8, 12, 13, 31}) {
    std::vector<double> h = some_numbers(2 * 9 * kBlocks * kSampleLanes);
    h[places[1] + lane] = std::numeric_limits<double>::infinity();
    const bool is_finite = make_rows(plan, {h.data(), places.data(), GetParam(), kBlocks}, false,
                                     kSize, room.data(), rows.data());
    EXPECT_EQ(is_finite, lane >= kSize) << lane;
  }
}

/// Blocks c n nᵀ or c I, by their factors or by their nine numbers.
TEST_P(TangentRowShapes, AreThoseOfTheirBlocks) {
  const TangentPlan plan = some_plan();
  const std::vector<std::uint32_t> places = {0, 9 * kBlocks * kSampleLanes};
  const std::vector<double> c = some_numbers(2 * 9 * kBlocks * kSampleLanes);
  std::vector<double> h(c.size());
  for (const std::uint32_t sample : places)
    for (std::size_t k = 0; k < kRowLanes; ++k) {
      const auto number = [&](std::size_t q) { return c[sample + q * kSampleLanes + k]; };
      const Eigen::Vector3d n(number(kBlocks), number(kBlocks + 1), number(kBlocks + 2));
      Eigen::Matrix3d shape = Eigen::Matrix3d::Identity();
      if (GetParam() == TangentShape::normal) shape = n * n.transpose();
      for (std::size_t block = 0; block < kBlocks; ++block)
        for (std::size_t q = 0; q < 9; ++q)
          h[sample + (9 * block + q) * kSampleLanes + k] =
              GetParam() == TangentShape::blocks
                  ? number(9 * block + q)
                  : number(block) * shape(static_cast<Index>(q / 3), static_cast<Index>(q % 3));
    }
  std::vector<double> room(room_for(plan));
  for (const bool adds : {false, true}) {
    std::vector<double> rows = some_numbers(kNumbers * kRowLanes), expected = rows;
    EXPECT_TRUE(make_rows(plan, {c.data(), places.data(), GetParam(), kBlocks}, adds, kRowLanes,
                          room.data(), rows.data()));
    EXPECT_TRUE(make_rows(plan, {h.data(), places.data(), TangentShape::blocks, kBlocks}, adds,
                          kRowLanes, room.data(), expected.data()));
    for (std::size_t i = 0; i < rows.size(); ++i) ASSERT_NEAR(rows[i], expected[i], 1e-13) << i;
  }
}

/// Σ d (Σ l h) by the plan as it reads.
TEST_F(TangentRowShapes, AreTheSumsThatThePlanSays) {
  const TangentPlan plan = some_plan();
  const std::vector<std::uint32_t> places = {2, 9 * kBlocks * kSampleLanes};
  const std::vector<double> h = some_numbers(2 * 9 * kBlocks * kSampleLanes);
  const auto block = [&](std::size_t sample, std::size_t b) {
    Eigen::Matrix3d m;
    for (std::size_t q = 0; q < 9; ++q)
      m(static_cast<Index>(q / 3), static_cast<Index>(q % 3)) =
          h[places[sample] + (9 * b + q) * kSampleLanes];
    return m;
  };
  const std::array<Eigen::Matrix3d, 3> parts{0.5 * block(0, 0) - 2 * block(0, 1).transpose(),
                                             3 * block(0, 1), 1.5 * block(1, 0).transpose()};
  const std::array<Eigen::Matrix3d, 3> expected{0.25 * parts[0] - parts[1] + 4 * parts[2],
                                                Eigen::Matrix3d::Zero(),
                                                3 * parts[0] - 0.5 * parts[2]};
  std::vector<double> room(room_for(plan)), row(kNumbers, 1);
  EXPECT_TRUE(make_row(plan, {h.data(), places.data(), TangentShape::blocks, kBlocks}, false,
                       room.data(), row.data()));
  for (std::size_t i = 0; i < row.size(); ++i)
    EXPECT_NEAR(row[i], expected[i / 9](static_cast<Index>(i % 9 / 3), static_cast<Index>(i % 3)),
                1e-14);
}

}  // namespace
}  // namespace deform
