#include "fill_kernels.h"

#include <deform/kernel.h>

#include "vectors.h"

namespace multigrid {
namespace {

/// Four nodes' lanes, one after another.
[[gnu::always_inline]] inline Quad beside(const Single& a, const Single& b, const Single& c,
                                          const Single& d) {
  const HalfQuad ab = __builtin_shufflevector(a, b, 0, 1, 2, 3, 4, 5, 6, 7),
                 cd = __builtin_shufflevector(c, d, 0, 1, 2, 3, 4, 5, 6, 7);
  return __builtin_shufflevector(ab, cd, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
}

/// Three numbers in single precision, and a 0.
[[gnu::always_inline]] inline Single first_three(const DoubleSingle& v) {
  return __builtin_shufflevector(__builtin_convertvector(v, Single), Single{}, 0, 1, 2, 4);
}
[[gnu::always_inline]] inline Single last_three(const DoubleSingle& v) {
  return __builtin_shufflevector(__builtin_convertvector(v, Single), Single{}, 1, 2, 3, 4);
}

[[gnu::always_inline]] inline void write_columns(const Single& a, const Single& b, const Single& c,
                                                 float* to) {
  store(a, to);
  store(b, to + 16);
  store(c, to + 32);
}

}  // namespace

DEFORM_KERNEL void add_scalars(float weight, const FourRows& from, const std::uint16_t* slot,
                               Index size, float* to) {
  const float *const a = from[0], *const b = from[1], *const c = from[2], *const d = from[3];
  for (Index k = 0; k < size; ++k) {
    const Single entry{a[4 * k], b[4 * k], c[4 * k], d[4 * k]};
    float* const sum = to + 4 * std::size_t{slot[k]};
    store(load<Single>(sum) + weight * entry, sum);
  }
}

DEFORM_KERNEL void add_blocks(float weight, const FourRows& from, const std::uint16_t* slot,
                              Index size, float* to) {
  const float *const a = from[0], *const b = from[1], *const c = from[2], *const d = from[3];
  for (Index k = 0; k < size; ++k) {
    float* const sum = to + 48 * std::size_t{slot[k]};
    for (Index i = 0; i < 48; i += 16) {
      const Index at = 48 * k + i;
      const Quad column = beside(load<Single>(a + at), load<Single>(b + at), load<Single>(c + at),
                                 load<Single>(d + at));
      store(load<Quad>(sum + i) + weight * column, sum + i);
    }
  }
}

DEFORM_KERNEL void combine_scalars(const Share* share, const std::uint16_t* end, Index size,
                                   const float* t, float* sums) {
  const Share* next = share;
  for (Index k = 0; k < size; ++k) {
    Single sum{};
    for (; next != share + end[k]; ++next)
      sum += next->weight * load<Single>(t + 4 * std::size_t{next->from});
    store(sum, sums + 4 * k);
  }
}

DEFORM_KERNEL void combine_blocks(const Share* share, const std::uint16_t* end, Index size,
                                  const float* t, float* sums) {
  const Share* next = share;
  for (Index k = 0; k < size; ++k) {
    Quad x{}, y{}, z{};
    for (; next != share + end[k]; ++next) {
      const float* const entry = t + 48 * std::size_t{next->from};
      x += next->weight * load<Quad>(entry);
      y += next->weight * load<Quad>(entry + 16);
      z += next->weight * load<Quad>(entry + 32);
    }
    store(x, sums + 48 * k);
    store(y, sums + 48 * k + 16);
    store(z, sums + 48 * k + 32);
  }
}

DEFORM_KERNEL void write_blocks(const double* blocks, const std::int32_t* upper,
                                const std::int32_t* lower, Index size, float* value) {
  for (Index k = 0; k < size; ++k) {
    const double* const from = blocks + 9 * k;
    // Rows of the block; of the last one no number behind it is read.
    const Single a = first_three(load<DoubleSingle>(from)),
                 b = first_three(load<DoubleSingle>(from + 3)),
                 c = last_three(load<DoubleSingle>(from + 5));
    write_columns(a, b, c, value + start_of_block(lower[k]));
    const Single ab = __builtin_shufflevector(a, b, 0, 4, 1, 5),
                 ab_last = __builtin_shufflevector(a, b, 2, 6, 3, 7);
    write_columns(
        __builtin_shufflevector(ab, c, 0, 1, 4, 7), __builtin_shufflevector(ab, c, 2, 3, 5, 7),
        __builtin_shufflevector(ab_last, c, 0, 1, 6, 7), value + start_of_block(upper[k]));
  }
}

}  // namespace multigrid
