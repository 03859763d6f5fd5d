/// Products with strips of rows, and their filling, on raw arrays.
#pragma once

#include <cstdint>

#include "field.h"

namespace multigrid {

/// A strip's numbers: number q of entry e at value[(numbers · e + q) · lanes + row].
template <class Value>
struct StripValues {
  const Value* value;
  Index lanes;  ///< rows, padded
  const std::int32_t* distance;
  Index entries;
};

/// upper += A x and lower += (A − D)ᵀ x for a strip's rows of the upper half A with the diagonal D,
/// each from the strip's first row on; `lower` is written at all columns. Two arrays, as one's
/// loads would wait for the other's stores.
void multiply_blocks(const StripValues<float>& of, const Components<const float>& field,
                     const Components<float>& to_upper, const Components<float>& to_lower);
/// The same for one number an entry, for x, y and z alike; in double precision where small masses
/// beside large stiffnesses would no longer be what they were.
void multiply_scalars(const StripValues<float>& a, const Components<const float>& x,
                      const Components<float>& upper, const Components<float>& lower);
void multiply_scalars(const StripValues<double>& a, const Components<const float>& x,
                      const Components<double>& upper, const Components<double>& lower);
void multiply_scalars(const StripValues<double>& a, const Components<const double>& x,
                      const Components<double>& upper, const Components<double>& lower);

/// upper and lower, one number a row, += sums of magnitudes of a strip's entries.
void add_magnitudes(const StripValues<float>& of, float* upper, float* lower);

/// out = upper + lower.
void add_halves(Index size, const float* upper, const float* lower, float* out);
void add_halves(Index size, const double* upper, const double* lower, float* out);
void add_halves(Index size, const double* upper, const double* lower, double* out);
/// out += part.
void add_part(Index size, const float* part, float* out);
void add_part(Index size, const double* part, float* out);
void add_part(Index size, const double* part, double* out);

/// Some rows of a strip, side by side in double precision: number q of entry e of the k-th at
/// value[(9 e + q) · lanes + k]. `column`: of the first row's entries, `row`
/// being that row.
struct RowsToPut {
  const double* value;
  Index lanes, size;
  const std::int32_t* column;
  Index entries;
  std::int32_t row;
};
/// Puts them, in single precision, where their first row lies in a strip of such distances, number
/// q of entry e at to[(9 e + q) · lanes].
void put_blocks(const RowsToPut& put, const std::int32_t* distance, Index lanes, float* to);

}  // namespace multigrid
