/// Entries of a matrix between two nodes: a 3 × 3 block, or one number that x, y and z share.
#pragma once

#include "field_kernels.h"
#include "galerkin_kernels.h"
#include "strip_kernels.h"

namespace multigrid {

/// Nine numbers, row by row; its mirror image has the columns for rows.
struct Block {
  static constexpr Index kNumbers = 9, kInverse = 6;
  static constexpr Index kComponents = 3;  ///< that an entry couples
  static void multiply(const StripValues<float>& a, const Components<const float>& x,
                       const Components<float>& upper, const Components<float>& lower) {
    multiply_blocks(a, x, upper, lower);
  }
  static void smooth(Index first, Index size, float omega, const Inverse& inverse,
                     const Components<const float>& r, const Components<float>& x, bool adds) {
    smooth_blocks(first, size, omega, inverse, r, x, adds);
  }
  static void invert(Index size, const float* diagonal, Index lanes, float* inverse, Index stride) {
    invert_blocks(size, diagonal, lanes, inverse, stride);
  }
  static void combine(const CoarseRows& rows, const float* fine, float* coarse) {
    combine_blocks(rows, fine, coarse);
  }
};

/// A multiple of the identity.
struct Scalar {
  static constexpr Index kNumbers = 1, kInverse = 1;
  static constexpr Index kComponents = 1;
  template <class Value, class X, class Sum>
  static void multiply(const StripValues<Value>& a, const Components<const X>& x,
                       const Components<Sum>& upper, const Components<Sum>& lower) {
    multiply_scalars(a, x, upper, lower);
  }
  static void smooth(Index first, Index size, float omega, const Inverse& inverse,
                     const Components<const float>& r, const Components<float>& x, bool adds) {
    smooth_scalars(first, size, omega, inverse, r, x, adds);
  }
  static void invert(Index size, const float* diagonal, Index /*lanes*/, float* inverse,
                     Index /*stride*/) {
    invert_scalars(size, diagonal, inverse);
  }
  static void combine(const CoarseRows& rows, const float* fine, float* coarse) {
    combine_scalars(rows, fine, coarse);
  }
};

}  // namespace multigrid
