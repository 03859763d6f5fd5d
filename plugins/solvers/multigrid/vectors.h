/// Vectors of the processor, as kernels use them. For source files with kernels alone: they pass
/// between functions that are all inlined.
#pragma once

#include <cstring>

#include "field.h"

#pragma GCC diagnostic ignored "-Wpsabi"

namespace multigrid {

/// A vector of so many bytes.
template <class Number, int bytes>
struct VectorOf {
  using Type [[gnu::vector_size(bytes)]] = Number;
};
template <class Number, int bytes>
using Vector = typename VectorOf<Number, bytes>::Type;

template <class V>
inline constexpr Index kSize = sizeof(V) / sizeof(V{}[0]);

template <class V, class Number>
[[gnu::always_inline]] inline V load(const Number* from) {
  V v;
  std::memcpy(&v, from, sizeof v);
  return v;
}
template <class V, class Number>
[[gnu::always_inline]] inline void store(const V& v, Number* to) {
  std::memcpy(to, &v, sizeof v);
}

}  // namespace multigrid
