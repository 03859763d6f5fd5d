#include "galerkin_kernels.h"

#include <cstring>

#include <deform/kernel.h>

#include "vectors.h"

namespace multigrid {
namespace {

/// Numbers of as many rows as a vector has, `step` apart.
template <class V, Index step>
[[gnu::always_inline]] inline V rows_from(const float* from) {
  if constexpr (step == 1) {
    return load<V>(from);
  } else {
    const V low = load<V>(from), high = load<V>(from + kSize<V>);
    if constexpr (kSize<V> == 16)
      return __builtin_shufflevector(low, high, 0, 2, 4, 6, 8, 10, 12, 14, 16, 18, 20, 22, 24, 26,
                                     28, 30);
    else if constexpr (kSize<V> == 8)
      return __builtin_shufflevector(low, high, 0, 2, 4, 6, 8, 10, 12, 14);
    else
      return __builtin_shufflevector(low, high, 0, 2, 4, 6);
  }
}

/// Entry number k of rows from `lane` on, as many as a vector has.
template <class V, Index numbers, Index step>
[[gnu::always_inline]] inline void combine_entry(const CoarseRows& rows, Index k, Index lane,
                                                 const Term* next, const float* fine,
                                                 float* coarse) {
  static constexpr Index kMirrored[9] = {0, 3, 6, 1, 4, 7, 2, 5, 8};
  fine += step * lane;
  V sum[numbers]{};
  for (const Term* end = rows.term + rows.end[2 * k]; next != end; ++next) {
    const Place at = rows.source[next->source];
    for (Index q = 0; q < numbers; ++q)
      sum[q] += next->weight * rows_from<V, step>(fine + at.first + q * at.stride);
  }
  for (const Term* end = rows.term + rows.end[2 * k + 1]; next != end; ++next) {
    const Place at = rows.source[next->source];
    for (Index q = 0; q < numbers; ++q)
      sum[q] += next->weight * rows_from<V, step>(fine + at.first + kMirrored[q] * at.stride);
  }
  float* to = coarse + rows.to[k].first + lane;
  const Index left = rows.size - lane;
  for (Index q = 0; q < numbers; ++q, to += rows.to[k].stride) {
    if (left >= kSize<V>)
      store(sum[q], to);
    else
      std::memcpy(to, &sum[q], static_cast<std::size_t>(left) * sizeof(float));
  }
}

template <int bytes, Index numbers, Index step>
[[gnu::always_inline]] inline void combine(const CoarseRows& of, const float* fine, float* coarse) {
  using Rows = Vector<float, bytes>;
  const CoarseRows rows = of;
  const Term* first = rows.term;
  for (Index k = 0; k < rows.entries; ++k) {
    for (Index lane = 0; lane < rows.size; lane += kSize<Rows>)
      combine_entry<Rows, numbers, step>(rows, k, lane, first, fine, coarse);
    first = rows.term + rows.end[2 * k + 1];
  }
}

template <int bytes, Index numbers>
[[gnu::always_inline]] inline void combine(const CoarseRows& rows, const float* fine,
                                           float* coarse) {
  if (rows.step == 2)
    combine<bytes, numbers, 2>(rows, fine, coarse);
  else
    combine<bytes, numbers, 1>(rows, fine, coarse);
}
template <int bytes>
[[gnu::always_inline]] inline void combine_blocks_by(const CoarseRows& rows, const float* fine,
                                                     float* coarse) {
  combine<bytes, 9>(rows, fine, coarse);
}
template <int bytes>
[[gnu::always_inline]] inline void combine_scalars_by(const CoarseRows& rows, const float* fine,
                                                      float* coarse) {
  combine<bytes, 1>(rows, fine, coarse);
}

}  // namespace

DEFORM_VECTOR_KERNEL(void, combine_blocks,
                     (const CoarseRows& rows, const float* fine, float* coarse),
                     (rows, fine, coarse))
DEFORM_VECTOR_KERNEL(void, combine_scalars,
                     (const CoarseRows& rows, const float* fine, float* coarse),
                     (rows, fine, coarse))

}  // namespace multigrid
