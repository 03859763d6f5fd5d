/// Rows of tangents, made and moved side by side: as one by one.
#include "solve/tangent_rows.h"

#include <limits>
#include <random>

#include <gtest/gtest.h>

namespace deform {
namespace {

class TangentRows : public testing::TestWithParam<Index> {
 protected:
  std::vector<double> some_numbers(std::size_t size) {
    std::vector<double> numbers(size);
    for (double& x : numbers) x = uniform_(random_);
    return numbers;
  }

 private:
  std::mt19937 random_{7};
  std::uniform_real_distribution<double> uniform_{-1, 1};
};

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

/// Numbers that lie further on by a lane belong to the next row.
TEST_F(TangentRows, SideBySideHaveTheBitsOfOneByOne) {
  TangentPlan plan;
  plan.left = {{1, 0, false, true, 0.5}, {1, 1, true, false, -2}, {2, 1, false, true, 3}};
  plan.right = {{1, 0, 0.25}, {2, 0, -1}, {1, 2, 4}};
  plan.samples = {{0, 3, 0, 3}, {0, 2, 2, 3}};
  constexpr Index kNumbers = 27;
  const std::vector<double> h = some_numbers(static_cast<std::size_t>(2 * 18 * kSampleLanes));
  const std::vector<std::uint32_t> places = {3, 18 * kSampleLanes};
  std::vector<double> rows(static_cast<std::size_t>(kNumbers * kRowLanes), 0);
  add_to_rows(plan, h.data(), places.data(), rows.data());
  for (std::uint32_t k = 0; k < kRowLanes; ++k) {
    std::vector<double> row(kNumbers, 0);
    const std::vector<std::uint32_t> of_row = {places[0] + k, places[1] + k};
    add_to_row(plan, h.data(), of_row.data(), row.data());
    for (std::size_t i = 0; i < row.size(); ++i)
      ASSERT_EQ(rows[i * kRowLanes + k], row[i]) << k << ", " << i;
  }
}

}  // namespace
}  // namespace deform
