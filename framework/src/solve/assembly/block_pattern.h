/// Builds the pattern of a BlockMatrix from entries in any order.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "deform/solve/block_matrix.h"
#include "deform/types.h"

namespace deform {

class BlockPatternBuilder {
 public:
  explicit BlockPatternBuilder(Index nodes) : rows_(static_cast<std::size_t>(nodes)) {}
  /// (a, b) or (b, a): the one of the upper half.
  void add(Index a, Index b) {
    auto& row = rows_[static_cast<std::size_t>(std::min(a, b))];
    row.push_back(static_cast<std::int32_t>(std::max(a, b)));
    if (row.size() >= 256) compress(row);  // the same block comes from many samples
  }
  /// Without values; every diagonal block is there.
  [[nodiscard]] BlockMatrix build() {
    BlockMatrix pattern;
    pattern.nodes = static_cast<Index>(rows_.size());
    for (std::size_t a = 0; a < rows_.size(); ++a) {
      rows_[a].push_back(static_cast<std::int32_t>(a));
      compress(rows_[a]);
      pattern.column.insert(pattern.column.end(), rows_[a].begin(), rows_[a].end());
      pattern.row_begin.push_back(static_cast<std::int32_t>(pattern.column.size()));
      rows_[a] = {};
    }
    return pattern;
  }

 private:
  static void compress(std::vector<std::int32_t>& row) {
    std::ranges::sort(row);
    row.erase(std::unique(row.begin(), row.end()), row.end());
  }
  std::vector<std::vector<std::int32_t>> rows_;
};

}  // namespace deform
