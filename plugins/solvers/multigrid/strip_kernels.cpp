#include "strip_kernels.h"

#include <type_traits>

#include <deform/kernel.h>

#include "vectors.h"

// Of lambdas: they are compiled for the processor of the kernel that they are part of.
#define DEFORM_INLINE __attribute__((always_inline))

namespace multigrid {
namespace {

/// Rows at once: vectors of so many bytes, and of four numbers.
template <class Number, int bytes>
struct Rows {
  using Many = Vector<Number, bytes>;
  using Few = Vector<Number, 4 * sizeof(Number)>;
};

/// As many rows as a vector has, of what has the same precision or half of it.
template <class V>
[[gnu::always_inline]] inline V rows(const float* from) {
  if constexpr (sizeof(V{}[0]) == sizeof(float)) {
    return load<V>(from);
  } else {
    return __builtin_convertvector((load<Vector<float, sizeof(V) / 2>>(from)), V);
  }
}
template <class V>
[[gnu::always_inline]] inline V rows(const double* from) {
  return load<V>(from);
}

/// Entries of some rows, in turn: vectors of many rows, then of few.
template <class Number, int bytes, class Body>
[[gnu::always_inline]] inline void each_rows(Index lanes, const Body& body) {
  using Many = typename Rows<Number, bytes>::Many;
  using Few = typename Rows<Number, bytes>::Few;
  Index row = 0;
  for (; row + kSize<Many> <= lanes; row += kSize<Many>) body(row, std::type_identity<Many>{});
  for (; row < lanes; row += kSize<Few>) body(row, std::type_identity<Few>{});
}

/// A += v, at `to`.
template <class V, class Number>
[[gnu::always_inline]] inline void add_to(const V& v, Number* to) {
  store(load<V>(to) + v, to);
}

/// One number an entry: a row's sums stay in registers over its entries.
template <int bytes, class Value, class X, class Sum>
[[gnu::always_inline]] inline void multiply_scalars_by(const StripValues<Value>& of,
                                                       const Components<const X>& field,
                                                       const Components<Sum>& to_upper,
                                                       const Components<Sum>& to_lower) {
  const StripValues<Value> a = of;
  const Components<const X> x = field;
  const Components<Sum> upper = to_upper, lower = to_lower;
  // Which rows go together decides in which order columns are added to: the same at any width.
  each_rows<Sum, 32>(a.lanes, [&](Index row, auto kind) DEFORM_INLINE {
    using V = typename decltype(kind)::type;
    V of_row[3], sum[3];
    const auto diagonal = rows<V>(a.value + row);
    for (Index c = 0; c < 3; ++c) {
      of_row[c] = rows<V>(x.data + c * x.stride + row);
      sum[c] = diagonal * of_row[c];
    }
    for (Index e = 1; e < a.entries; ++e) {
      const auto v = rows<V>(a.value + e * a.lanes + row);
      const Index column = row + a.distance[e];
      for (Index c = 0; c < 3; ++c) {
        sum[c] += v * rows<V>(x.data + c * x.stride + column);
        add_to(v * of_row[c], lower.data + c * lower.stride + column);
      }
    }
    for (Index c = 0; c < 3; ++c) add_to(sum[c], upper.data + c * upper.stride + row);
  });
}

/// Entry by entry, so that the matrix is read in the order in which it lies.
template <int bytes>
[[gnu::always_inline]] inline void multiply_blocks_by(const StripValues<float>& of,
                                                      const Components<const float>& field,
                                                      const Components<float>& to_upper,
                                                      const Components<float>& to_lower) {
  const StripValues<float> a = of;
  const Components<const float> x = field;
  const Components<float> upper = to_upper, lower = to_lower;
  for (Index e = 0; e < a.entries; ++e) {
    const float* const value = a.value + 9 * e * a.lanes;
    const Index distance = a.distance[e];
    each_rows<float, bytes>(a.lanes, [&](Index row, auto kind) DEFORM_INLINE {
      using V = typename decltype(kind)::type;
      V of_row[3], of_column[3];
      for (Index c = 0; c < 3; ++c) {
        of_row[c] = load<V>(x.data + c * x.stride + row);
        of_column[c] = load<V>(x.data + c * x.stride + row + distance);
      }
      V along[3]{};  // what the column gets
      for (Index i = 0; i < 3; ++i) {
        V sum{};
        for (Index j = 0; j < 3; ++j) {
          const auto v = load<V>(value + (3 * i + j) * a.lanes + row);
          sum += v * of_column[j];
          along[j] += v * of_row[i];
        }
        add_to(sum, upper.data + i * upper.stride + row);
      }
      if (e == 0) return;  // a diagonal block is its own mirror image
      for (Index j = 0; j < 3; ++j)
        add_to(along[j], lower.data + j * lower.stride + row + distance);
    });
  }
}

template <int bytes>
[[gnu::always_inline]] inline void add_magnitudes_by(const StripValues<float>& of, float* upper,
                                                     float* lower) {
  const StripValues<float> a = of;
  for (Index e = 0; e < a.entries; ++e) {
    const float* const value = a.value + e * a.lanes;
    float* const column = lower + a.distance[e];
    each_rows<float, bytes>(a.lanes, [&](Index row, auto kind) DEFORM_INLINE {
      using V = typename decltype(kind)::type;
      const auto v = load<V>(value + row);
      const V magnitude = v < 0 ? -v : v;
      add_to(magnitude, upper + row);
      if (e > 0) add_to(magnitude, column + row);
    });
  }
}

}  // namespace

DEFORM_VECTOR_KERNEL(void, multiply_blocks,
                     (const StripValues<float>& a, const Components<const float>& x,
                      const Components<float>& upper, const Components<float>& lower),
                     (a, x, upper, lower))
DEFORM_VECTOR_KERNEL(void, multiply_scalars,
                     (const StripValues<float>& a, const Components<const float>& x,
                      const Components<float>& upper, const Components<float>& lower),
                     (a, x, upper, lower))
DEFORM_VECTOR_KERNEL(void, multiply_scalars,
                     (const StripValues<double>& a, const Components<const float>& x,
                      const Components<double>& upper, const Components<double>& lower),
                     (a, x, upper, lower))
DEFORM_VECTOR_KERNEL(void, multiply_scalars,
                     (const StripValues<double>& a, const Components<const double>& x,
                      const Components<double>& upper, const Components<double>& lower),
                     (a, x, upper, lower))
DEFORM_VECTOR_KERNEL(void, add_magnitudes,
                     (const StripValues<float>& of, float* upper, float* lower), (of, upper, lower))

namespace {

template <class Sum, class Out>
[[gnu::always_inline]] inline void add_both(Index size, const Sum* upper, const Sum* lower,
                                            Out* out) {
#pragma GCC ivdep
  for (Index i = 0; i < size; ++i) out[i] = static_cast<Out>(upper[i] + lower[i]);
}
template <class Sum, class Out>
[[gnu::always_inline]] inline void add_one(Index size, const Sum* part, Out* out) {
#pragma GCC ivdep
  for (Index i = 0; i < size; ++i) out[i] = static_cast<Out>(static_cast<Sum>(out[i]) + part[i]);
}

}  // namespace

DEFORM_KERNEL void add_halves(Index size, const float* upper, const float* lower, float* out) {
  add_both(size, upper, lower, out);
}
DEFORM_KERNEL void add_halves(Index size, const double* upper, const double* lower, float* out) {
  add_both(size, upper, lower, out);
}
DEFORM_KERNEL void add_halves(Index size, const double* upper, const double* lower, double* out) {
  add_both(size, upper, lower, out);
}
DEFORM_KERNEL void add_part(Index size, const float* part, float* out) { add_one(size, part, out); }
DEFORM_KERNEL void add_part(Index size, const double* part, float* out) {
  add_one(size, part, out);
}
DEFORM_KERNEL void add_part(Index size, const double* part, double* out) {
  add_one(size, part, out);
}

DEFORM_KERNEL void put_blocks(const RowsToPut& put, const std::int32_t* distance, Index lanes,
                              float* to) {
  const RowsToPut rows = put;
  const double* from = rows.value;
  for (Index e = 0, at = 0; e < rows.entries; ++e) {
    while (distance[at] < rows.column[e] - rows.row) ++at;
    float* number = to + 9 * at * lanes;
    for (Index q = 0; q < 9; ++q, from += rows.lanes, number += lanes) {
#pragma GCC ivdep
      for (Index k = 0; k < rows.size; ++k) number[k] = static_cast<float>(from[k]);
    }
  }
}

}  // namespace multigrid
