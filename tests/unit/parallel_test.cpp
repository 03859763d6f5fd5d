// Loops over blocks. Built with the thread sanitizer these tests also show that what comes before a
// loop, its blocks and what comes after it are ordered for it.
#include "deform/parallel.h"

#include <numeric>
#include <stdexcept>
#include <vector>

#include <gtest/gtest.h>

namespace {
using namespace deform;

TEST(ParallelBlocks, EveryNumberIsInOneBlock) {
  constexpr Index count = 10007;
  for (const Index block : {Index{1}, Index{128}, count + 1}) {
    std::vector<int> seen(static_cast<std::size_t>(count), 0);
    parallel_blocks(count, block, [&](Index first, Index size) {
      EXPECT_LE(size, block);
      for (Index i = first; i < first + size; ++i) ++seen[static_cast<std::size_t>(i)];
    });
    EXPECT_EQ(seen, std::vector<int>(static_cast<std::size_t>(count), 1));
  }
  parallel_blocks(0, 128, [](Index, Index) { FAIL() << "there is no block"; });
}

TEST(ParallelBlocks, LoopsFollowEachOther) {
  constexpr Index count = 4096, block = 16;
  std::vector<double> before(static_cast<std::size_t>(count)), after(before.size());
  for (int round = 0; round < 50; ++round) {
    std::iota(before.begin(), before.end(), round);
    parallel_blocks(count, block, [&](Index first, Index size) {
      for (Index i = first; i < first + size; ++i)
        after[static_cast<std::size_t>(i)] = 2 * before[static_cast<std::size_t>(count - 1 - i)];
    });
    EXPECT_EQ(after.front(), 2.0 * static_cast<double>(count - 1 + round));
    EXPECT_EQ(after.back(), 2.0 * round);
  }
}

TEST(ParallelBlocks, WhatABlockThrowsComesOut) {
  std::vector<int> done(64, 0);
  EXPECT_THROW(parallel_blocks(64, 1,
                               [&](Index i, Index) {
                                 done[static_cast<std::size_t>(i)] = 1;
                                 if (i == 32) throw std::runtime_error("block 32");
                               }),
               std::runtime_error);
  EXPECT_EQ(done[32], 1);
}

}  // namespace
