/// Entries of a matrix between two nodes: a 3 × 3 block, or one number that x, y and z share.
#pragma once

#include <array>

#include <Eigen/LU>

#include "lanes.h"

namespace multigrid {

/// 3 × 3, column-major without padding; reading the last column reads one number beyond it.
struct Block {
  static constexpr int kSize = 9, kColumns = 3;
  static Lanes apply(const float* a, const Lanes& x) {
    return x[0] * Lanes::load(a) + x[1] * Lanes::load(a + 3) + x[2] * Lanes::load(a + 6);
  }
};

/// A multiple of the identity.
struct Scalar {
  static constexpr int kSize = 1, kColumns = 1;
  static Lanes apply(const float* a, const Lanes& x) { return a[0] * x; }
};

/// Sums of blocks, one register a column; a scalar is in the first lane.
template <class Entry>
using Sum = std::array<Lanes, Entry::kColumns>;

template <class Entry>
inline void add(Sum<Entry>& sum, float factor, const float* a) {
  for (std::size_t c = 0; c < sum.size(); ++c) sum[c] += factor * Lanes::load(a + 3 * c);
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
  for (int c = 0; c < 3; ++c)
    for (int i = 0; i < 3; ++i) a[3 * c + i] = sum[static_cast<std::size_t>(c)][i];
}
inline void store(const Sum<Scalar>& sum, float* a) { a[0] = sum[0][0]; }

/// The inverse of a diagonal block; components that nothing resists count as resisted by 1.
inline void invert(const float* a, std::array<float, Block::kSize>& inverse) {
  Eigen::Matrix3d m = Eigen::Map<const Eigen::Matrix3f>(a).cast<double>();
  for (int c = 0; c < 3; ++c)
    if (!(m(c, c) > 0)) m.row(c).setZero(), m.col(c).setZero(), m(c, c) = 1;
  Eigen::Map<Eigen::Matrix3f>(inverse.data()) = m.inverse().cast<float>();
}
inline void invert(const float* a, std::array<float, Scalar::kSize>& inverse) {
  inverse[0] = a[0] > 0 ? 1 / a[0] : 1;
}

}  // namespace multigrid
