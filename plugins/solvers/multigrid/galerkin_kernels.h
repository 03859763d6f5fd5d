/// Coarse rows of PᵀAP from the upper half of A, on raw arrays.
#pragma once

#include <compare>
#include <cstdint>

#include "strips.h"

namespace multigrid {

/// Coarse rows that are made at once.
inline constexpr Index kCoarseRows = 16;

/// A part of an entry of PᵀAP: an entry of A, or its mirror image, times a weight.
struct Term {
  std::uint16_t source = 0;
  float weight = 0;
  auto operator<=>(const Term&) const = default;
};

/// Rows that are made alike, at most kCoarseRows.
struct CoarseRows {
  Index size;           ///< of them
  Index step;           ///< fine rows from one to the next, 1 or 2
  const Place* source;  ///< in A, for the first row
  const Place* to;      ///< in PᵀAP, of each entry, for the first row
  Index entries;
  const Term* term;          ///< those of all entries
  const std::uint32_t* end;  ///< two an entry: of its terms, of its terms mirrored
};
void combine_blocks(const CoarseRows& rows, const float* fine, float* coarse);
void combine_scalars(const CoarseRows& rows, const float* fine, float* coarse);

}  // namespace multigrid
