/// How symmetric a sparse matrix is.
#pragma once

#include <algorithm>
#include <cmath>

#include "deform/solve/sparse_matrix.h"

namespace deform {

/// Entries of a symmetric operator that are summed in different orders agree to this part of the
/// largest.
inline constexpr double kRoundingOfSums = 1e-9;

[[nodiscard]] inline double largest_entry(const SparseMatrix& a) {
  double largest = 0;
  for (const double value : a.value) largest = std::max(largest, std::abs(value));
  return largest;
}

/// max |a_ij − a_ji|; the pattern is symmetric.
[[nodiscard]] inline double largest_asymmetry(const SparseMatrix& a) {
  double largest = 0;
  for (std::size_t i = 0; i < static_cast<std::size_t>(a.size); ++i)
    for (std::int32_t p = a.row_begin[i]; p < a.row_begin[i + 1]; ++p) {
      const auto j = static_cast<std::size_t>(a.column[static_cast<std::size_t>(p)]);
      const auto begin = a.column.begin() + a.row_begin[j],
                 end = a.column.begin() + a.row_begin[j + 1];
      const auto mirrored =
          std::lower_bound(begin, end, static_cast<std::int32_t>(i)) - a.column.begin();
      largest = std::max(largest, std::abs(a.value[static_cast<std::size_t>(p)] -
                                           a.value[static_cast<std::size_t>(mirrored)]));
    }
  return largest;
}

}  // namespace deform
