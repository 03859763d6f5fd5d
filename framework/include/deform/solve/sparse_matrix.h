/// The sparse matrix that linear solvers see.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "deform/types.h"

namespace deform {

/// Square matrix in compressed rows, columns ascending within a row; its pattern is symmetric even
/// where its values are not. (Read as compressed columns it is the transpose.)
struct SparseMatrix {
  Index size = 0;
  std::vector<std::int32_t> row_begin{0};  ///< (size + 1)
  std::vector<std::int32_t> column;
  std::vector<double> value;
};

/// What is known of a matrix before it is factorised.
struct MatrixTraits {
  Index size = 0;
  bool symmetric = false;
  /// Expected, not promised: a solver that needs it finds out.
  bool positive_definite = false;
  /// The surface's node of each unknown, where each belongs to another; else empty.
  std::span<const std::int32_t> nodes{};
};

}  // namespace deform
