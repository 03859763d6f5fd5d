#include "galerkin_kernels.h"

#include <cstring>

#include <deform/kernel.h>

#include "vectors.h"

namespace multigrid {
namespace {

/// Numbers of sixteen rows, `step` apart.
template <Index step>
[[gnu::always_inline]] inline SixteenFloats rows_from(const float* from) {
  if constexpr (step == 1) {
    return load<SixteenFloats>(from);
  } else {
    return __builtin_shufflevector(load<SixteenFloats>(from), load<SixteenFloats>(from + 16), 0, 2,
                                   4, 6, 8, 10, 12, 14, 16, 18, 20, 22, 24, 26, 28, 30);
  }
}

template <Index numbers, Index step>
[[gnu::always_inline]] inline void combine(const CoarseRows& of, const float* fine, float* coarse) {
  static constexpr Index kMirrored[9] = {0, 3, 6, 1, 4, 7, 2, 5, 8};
  const CoarseRows rows = of;
  const Term* next = rows.term;
  for (Index k = 0; k < rows.entries; ++k) {
    SixteenFloats sum[numbers]{};
    for (const Term* end = rows.term + rows.end[2 * k]; next != end; ++next) {
      const Place at = rows.source[next->source];
      for (Index q = 0; q < numbers; ++q)
        sum[q] += next->weight * rows_from<step>(fine + at.first + q * at.stride);
    }
    for (const Term* end = rows.term + rows.end[2 * k + 1]; next != end; ++next) {
      const Place at = rows.source[next->source];
      for (Index q = 0; q < numbers; ++q)
        sum[q] += next->weight * rows_from<step>(fine + at.first + kMirrored[q] * at.stride);
    }
    float* to = coarse + rows.to[k].first;
    for (Index q = 0; q < numbers; ++q, to += rows.to[k].stride) {
      if (rows.size == kCoarseRows)
        store(sum[q], to);
      else
        std::memcpy(to, &sum[q], static_cast<std::size_t>(rows.size) * sizeof(float));
    }
  }
}

template <Index numbers>
[[gnu::always_inline]] inline void combine(const CoarseRows& rows, const float* fine,
                                           float* coarse) {
  if (rows.step == 2)
    combine<numbers, 2>(rows, fine, coarse);
  else
    combine<numbers, 1>(rows, fine, coarse);
}

}  // namespace

DEFORM_KERNEL void combine_blocks(const CoarseRows& rows, const float* fine, float* coarse) {
  combine<9>(rows, fine, coarse);
}
DEFORM_KERNEL void combine_scalars(const CoarseRows& rows, const float* fine, float* coarse) {
  combine<1>(rows, fine, coarse);
}

}  // namespace multigrid
