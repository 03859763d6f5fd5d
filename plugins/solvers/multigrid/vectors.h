/// Vectors of the processor, as kernels use them. For source files with kernels alone: they pass
/// between functions that are all inlined.
#pragma once

#include <cstring>

#pragma GCC diagnostic ignored "-Wpsabi"

namespace multigrid {

using FourFloats [[gnu::vector_size(16)]] = float;
using EightFloats [[gnu::vector_size(32)]] = float;
using SixteenFloats [[gnu::vector_size(64)]] = float;
using FourDoubles [[gnu::vector_size(32)]] = double;
using EightDoubles [[gnu::vector_size(64)]] = double;

template <class Vector, class Number>
[[gnu::always_inline]] inline Vector load(const Number* from) {
  Vector v;
  std::memcpy(&v, from, sizeof v);
  return v;
}
template <class Vector, class Number>
[[gnu::always_inline]] inline void store(const Vector& v, Number* to) {
  std::memcpy(to, &v, sizeof v);
}

}  // namespace multigrid
