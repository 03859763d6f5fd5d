/// What iterations do with vectors of nodes, on raw arrays of one component.
#pragma once

#include "field.h"

namespace multigrid {

/// Σ a b, summed in double precision, in an order that depends on nothing but the size.
[[nodiscard]] double dot(Index size, const float* a, const float* b);
[[nodiscard]] double dot(Index size, const double* a, const double* b);
/// to += factor · from.
void add(Index size, float factor, const float* from, float* to);
void add(Index size, float factor, const float* from, double* to);
/// to = from + factor · to.
void scale_and_add(Index size, float factor, const float* from, float* to);
/// r = f − r.
void subtract_from(Index size, const float* f, float* r);
void subtract_from(Index size, const double* f, const double* product, float* r);

/// D⁻¹ of a matrix' diagonal: one number a node, or the upper half of a symmetric block, 00 01 02
/// 11 12 22, number q of node a at data[q · stride + a].
struct Inverse {
  const float* data;
  Index stride;
};
/// x = ω D⁻¹ r, or x += ω D⁻¹ r with `adds`, for nodes first … first+size−1.
void smooth_scalars(Index first, Index size, float omega, const Inverse& inverse,
                    const Components<const float>& r, const Components<float>& x, bool adds);
void smooth_blocks(Index first, Index size, float omega, const Inverse& inverse,
                   const Components<const float>& r, const Components<float>& x, bool adds);

/// The inverses of diagonal entries, whose numbers lie `lanes` apart; what nothing resists counts
/// as resisted by 1.
void invert_scalars(Index size, const float* diagonal, float* inverse);
void invert_blocks(Index size, const float* diagonal, Index lanes, float* inverse, Index stride);

}  // namespace multigrid
