/// Builds the symmetric pattern of a sparse matrix from entries in any order.
#pragma once

#include <algorithm>
#include <vector>

#include "deform/solve/sparse_matrix.h"

namespace deform {

class PatternBuilder {
 public:
  explicit PatternBuilder(Index size) : rows_(static_cast<std::size_t>(size)) {
    for (Index a = 0; a < size; ++a) add(a, a);
  }
  /// (a, b) and (b, a).
  void add(Index a, Index b) {
    insert(a, b);
    if (a != b) insert(b, a);
  }
  /// Zero values, every diagonal entry there.
  [[nodiscard]] SparseMatrix build() {
    SparseMatrix matrix;
    matrix.size = static_cast<Index>(rows_.size());
    for (auto& row : rows_) {
      compress(row);
      matrix.column.insert(matrix.column.end(), row.begin(), row.end());
      matrix.row_begin.push_back(static_cast<std::int32_t>(matrix.column.size()));
      row = {};
    }
    matrix.value.resize(matrix.column.size());
    return matrix;
  }

 private:
  void insert(Index a, Index b) {
    auto& row = rows_[static_cast<std::size_t>(a)];
    row.push_back(static_cast<std::int32_t>(b));
    if (row.size() >= 128) compress(row);  // the same entry comes from many samples
  }
  static void compress(std::vector<std::int32_t>& row) {
    std::ranges::sort(row);
    row.erase(std::unique(row.begin(), row.end()), row.end());
  }
  std::vector<std::vector<std::int32_t>> rows_;
};

}  // namespace deform
