/// Symmetric sparse matrices of 3 × 3 blocks, one row a node.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "deform/export.h"
#include "deform/types.h"

namespace deform {

/// Rows row … row+size−1 of a BlockMatrix, side by side, as they are made: number q of the k-th, in
/// the order in which that keeps a row's, at value[q · lanes + k]. The rows have the same
/// columns, each row's one further than those of the row before.
struct BlockRows {
  Index row = 0, size = 1;
  const double* value = nullptr;
  Index lanes = 1;
};

/// A symmetric 3 × 3 block a node (N × 6): xx, xy, xz, yy, yz, zz. None: (0 × 6).
using NodeBlocks = Eigen::Matrix<double, Eigen::Dynamic, 6>;

/// Symmetric (3N × 3N), upper half: the columns of row a are ≥ a, ascending, its diagonal block
/// first; 9 numbers a block, row-major.
struct DEFORM_API BlockMatrix {
  Index nodes = 0;
  std::vector<std::int32_t> row_begin{0};  ///< (N + 1), in blocks
  std::vector<std::int32_t> column;
  std::vector<double> value;

  using Block = Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>;
  /// The block (a, b), a ≤ b, which the pattern must have.
  [[nodiscard]] Block block(Index a, Index b) {
    const auto begin = column.begin() + row_begin[static_cast<std::size_t>(a)];
    const auto end = column.begin() + row_begin[static_cast<std::size_t>(a) + 1];
    const auto place = std::lower_bound(begin, end, static_cast<std::int32_t>(b)) - column.begin();
    return Block(value.data() + 9 * place);
  }

  [[nodiscard]] std::span<const std::int32_t> columns(Index a) const {
    const auto i = static_cast<std::size_t>(a);
    return {column.data() + row_begin[i], column.data() + row_begin[i + 1]};
  }
  /// Row a alone.
  [[nodiscard]] BlockRows row(Index a) const {
    return {a, 1, value.data() + 9 * Index{row_begin[static_cast<std::size_t>(a)]}, 1};
  }

  /// y = A x for x (N × 3).
  void multiply(const NodeVectors& x, NodeVectors& y) const;
};

}  // namespace deform
