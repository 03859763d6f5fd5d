/// Entries of a matrix between two nodes: a 3 × 3 block, or one number that x, y and z share.
#pragma once

#include <array>

#include <Eigen/LU>

#include "fill_kernels.h"
#include "lanes.h"

namespace multigrid {

/// The entry at a place (Quads): its columns of four lanes begin at value[start], `kStride` apart.
struct Block {
  static constexpr int kColumns = 3;
  static constexpr int kStride = 16;
  static constexpr std::size_t kSize = 12;  ///< numbers a place
  static std::size_t start(std::int32_t place) { return start_of_block(place); }
  static Lanes apply(const float* a, const Lanes& x) {
    return x[0] * Lanes::load(a) + x[1] * Lanes::load(a + kStride) +
           x[2] * Lanes::load(a + 2 * kStride);
  }
  static void multiply(const Quads::View& rows, const float* value, const float* y, Index first,
                       Index end, float* out) {
    multiply_blocks(rows, value, y, first, end, out);
  }
  static void smooth(const Smoothing& s, Index first, Index end, float* next) {
    smooth_blocks(s, first, end, next);
  }
  static void add_rows(float weight, const FourRows& from, const std::uint16_t* slot, Index size,
                       float* to) {
    add_blocks(weight, from, slot, size, to);
  }
  static void combine(const Share* share, const std::uint16_t* end, Index size, const float* t,
                      float* sums) {
    combine_blocks(share, end, size, t, sums);
  }
  /// Writes the entry of one row of four.
  static void store_row(const float* four, std::size_t row, float* to) {
    for (std::size_t c = 0; c < 48; c += 16) Lanes::load(four + c + 4 * row).store(to + c);
  }
};

/// A multiple of the identity.
struct Scalar {
  static constexpr int kColumns = 1;
  static constexpr int kStride = 1;
  static constexpr std::size_t kSize = 1;
  static std::size_t start(std::int32_t place) { return static_cast<std::size_t>(place); }
  static Lanes apply(const float* a, const Lanes& x) { return a[0] * x; }
  static void multiply(const Quads::View& rows, const float* value, const float* y, Index first,
                       Index end, float* out) {
    multiply_scalars(rows, value, y, first, end, out);
  }
  static void smooth(const Smoothing& s, Index first, Index end, float* next) {
    smooth_scalars(s, first, end, next);
  }
  static void add_rows(float weight, const FourRows& from, const std::uint16_t* slot, Index size,
                       float* to) {
    add_scalars(weight, from, slot, size, to);
  }
  static void combine(const Share* share, const std::uint16_t* end, Index size, const float* t,
                      float* sums) {
    combine_scalars(share, end, size, t, sums);
  }
  static void store_row(const float* four, std::size_t row, float* to) { to[0] = four[row]; }
};

/// Sums of blocks, one register a column; a scalar is in the first lane.
template <class Entry>
using Sum = std::array<Lanes, Entry::kColumns>;

template <class Entry>
inline void add(Sum<Entry>& sum, float factor, const float* a) {
  for (std::size_t c = 0; c < sum.size(); ++c, a += Entry::kStride)
    sum[c] += factor * Lanes::load(a);
}
template <>
inline void add<Scalar>(Sum<Scalar>& sum, float factor, const float* a) {
  sum[0].set(0, sum[0][0] + factor * a[0]);
}
template <class Entry>
inline void add(Sum<Entry>& sum, float factor, const Sum<Entry>& other) {
  for (std::size_t c = 0; c < sum.size(); ++c) sum[c] += factor * other[c];
}
inline void store(const Sum<Block>& sum, float* a) {
  for (std::size_t c = 0; c < sum.size(); ++c, a += Block::kStride) sum[c].store(a);
}
inline void store(const Sum<Scalar>& sum, float* a) { a[0] = sum[0][0]; }

/// The inverse of a diagonal block; components that nothing resists count as resisted by 1.
inline Sum<Block> inverse_of(const Sum<Block>& a) {
  Eigen::Matrix3d m;
  for (int c = 0; c < 3; ++c)
    for (int i = 0; i < 3; ++i) m(i, c) = static_cast<double>(a[static_cast<std::size_t>(c)][i]);
  for (int c = 0; c < 3; ++c)
    if (!(m(c, c) > 0)) m.row(c).setZero(), m.col(c).setZero(), m(c, c) = 1;
  m = m.inverse().eval();
  Sum<Block> inverse{};
  for (int c = 0; c < 3; ++c)
    for (int i = 0; i < 3; ++i)
      inverse[static_cast<std::size_t>(c)].set(i, static_cast<float>(m(i, c)));
  return inverse;
}
inline Sum<Scalar> inverse_of(const Sum<Scalar>& a) {
  Sum<Scalar> inverse{};
  inverse[0].set(0, a[0][0] > 0 ? 1 / a[0][0] : 1);
  return inverse;
}

}  // namespace multigrid
