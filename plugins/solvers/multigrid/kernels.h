/// What iterations spend their time with, on raw arrays: products of quads of rows with vectors of
/// nodes, and sums. Nodes have four lanes, of which the last is 0; vectors end with a whole quad.
#pragma once

#include "quads.h"

namespace multigrid {

/// Numbers that there must be behind a matrix's last, and the last of D⁻¹: kernels load whole
/// vectors, of which they take what they need.
inline constexpr std::size_t kOverrun = 12;

/// out = A y for quads first … end: one number an entry, for x, y and z alike.
void multiply_scalars(const Quads::View& rows, const float* value, const float* y, Index first,
                      Index end, float* out);
/// The same for 3 × 3 blocks: three columns an entry, each of four rows with four lanes.
void multiply_blocks(const Quads::View& rows, const float* value, const float* y, Index first,
                     Index end, float* out);

/// next = x + ω D⁻¹ (f − A x) for quads first … end, D⁻¹ being one number a node, or three columns
/// a quad as above; without `x`, ω D⁻¹ f.
struct Smoothing {
  const float *inverse, *f;
  float damping;
  const float *x = nullptr, *product = nullptr;  ///< `product`: A x
};
void smooth_scalars(const Smoothing& s, Index first, Index end, float* next);
void smooth_blocks(const Smoothing& s, Index first, Index end, float* next);

/// out = A y with A in double precision and sums so, too: small masses beside large stiffnesses are
/// no longer what they were when each entry has been rounded to single precision.
void multiply_scalars(const Quads::View& rows, const double* value, const float* y, Index first,
                      Index end, float* out);
/// r = b − A x for quads first … end, found in double precision.
void find_residual(const Quads::View& rows, const double* value, const double* x, const double* b,
                   Index first, Index end, float* r);

/// The sum of products of the nodes of quads first … end, in double precision.
[[nodiscard]] double dot(const float* a, const float* b, Index first, Index end);
[[nodiscard]] double dot(const double* a, const double* b, Index first, Index end);
/// to += factor · from, for quads first … end.
void add(float factor, const float* from, Index first, Index end, float* to);
void add(float factor, const float* from, Index first, Index end, double* to);
/// to = from + factor · to.
void scale_and_add(float factor, const float* from, Index first, Index end, float* to);

}  // namespace multigrid
