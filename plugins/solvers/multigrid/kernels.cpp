#include "kernels.h"

#include <cstring>

#include <deform/kernel.h>

#include "vectors.h"

namespace multigrid {
namespace {

/// The first four numbers, or the two from the first or third on, each in all lanes of its node.
/// The whole vector has been loaded (kOverrun): a compiler makes a wide vector of a narrow one by
/// way of memory, which waits for what has just been stored.
[[gnu::always_inline]] inline Quad spread(const Quad& v) {
  return __builtin_shufflevector(v, v, 0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3);
}
[[gnu::always_inline]] inline Pair spread_low(const Pair& v) {
  return __builtin_shufflevector(v, v, 0, 0, 0, 0, 1, 1, 1, 1);
}
[[gnu::always_inline]] inline Pair spread_high(const Pair& v) {
  return __builtin_shufflevector(v, v, 2, 2, 2, 2, 3, 3, 3, 3);
}
[[gnu::always_inline]] inline Quad first_lanes(const Quad& v) {
  return __builtin_shufflevector(v, v, 0, 0, 0, 0, 4, 4, 4, 4, 8, 8, 8, 8, 12, 12, 12, 12);
}
[[gnu::always_inline]] inline Quad second_lanes(const Quad& v) {
  return __builtin_shufflevector(v, v, 1, 1, 1, 1, 5, 5, 5, 5, 9, 9, 9, 9, 13, 13, 13, 13);
}
[[gnu::always_inline]] inline Quad third_lanes(const Quad& v) {
  return __builtin_shufflevector(v, v, 2, 2, 2, 2, 6, 6, 6, 6, 10, 10, 10, 10, 14, 14, 14, 14);
}

/// The vector's lanes at the columns of an entry.
template <class Number>
struct InSequence {
  const Number* y;
  const std::int32_t* column;
  [[gnu::always_inline]] const Number* at(std::int32_t e) const {
    return y + 4 * static_cast<std::size_t>(column[e]);
  }
};
template <class Number>
struct Gathered {
  const Number* y;
  const std::int32_t* column;  // of the quad's first entry
  std::int32_t first;          // entry
  mutable Number lanes[16];
  [[gnu::always_inline]] const Number* at(std::int32_t e) const {
    const std::int32_t* four = column + 4 * static_cast<std::size_t>(e - first);
    for (std::size_t row = 0; row < 4; ++row)
      std::memcpy(lanes + 4 * row, y + 4 * static_cast<std::size_t>(four[row]), 4 * sizeof(Number));
    return lanes;
  }
};

/// An entry of four rows, times the lanes at its columns: one number a row, or three columns.
struct ScalarEntry {
  static constexpr Index kNumbers = 4;
  [[gnu::always_inline]] static Quad times(const float* v, const Quad& x) {
    return spread(load<Quad>(v)) * x;
  }
};
struct BlockEntry {
  static constexpr Index kNumbers = 48;
  [[gnu::always_inline]] static Quad times(const float* v, const Quad& x) {
    return first_lanes(x) * load<Quad>(v) + second_lanes(x) * load<Quad>(v + 16) +
           third_lanes(x) * load<Quad>(v + 32);
  }
};

/// Sums over the entries of one quad: in single precision two chains, so that one does not wait for
/// the other; in double precision the two halves of the quad are.
template <class Entry, class Columns>
[[gnu::always_inline]] inline void sum_entries(const Columns& y, const float* value,
                                               std::int32_t first, std::int32_t end, float* out) {
  Quad even{}, odd{};
  std::int32_t e = first;
  for (; e + 1 < end; e += 2) {
    const float* v = value + Entry::kNumbers * e;
    even += Entry::times(v, load<Quad>(y.at(e)));
    odd += Entry::times(v + Entry::kNumbers, load<Quad>(y.at(e + 1)));
  }
  if (e < end) even += Entry::times(value + Entry::kNumbers * e, load<Quad>(y.at(e)));
  store(even + odd, out);
}
[[gnu::always_inline]] inline Pair two_nodes(const double* lanes) { return load<Pair>(lanes); }
[[gnu::always_inline]] inline Pair two_nodes(const float* lanes) {
  return __builtin_convertvector(load<HalfQuad>(lanes), Pair);
}
template <class Entry, class Columns>
[[gnu::always_inline]] inline void sum_entries(const Columns& y, const double* value,
                                               std::int32_t first, std::int32_t end, double* out) {
  Pair low{}, high{};
  for (std::int32_t e = first; e < end; ++e) {
    const Pair v = load<Pair>(value + Entry::kNumbers * e);
    const auto* lanes = y.at(e);
    low += spread_low(v) * two_nodes(lanes);
    high += spread_high(v) * two_nodes(lanes + 8);
  }
  store(low, out);
  store(high, out + 8);
}

template <class Entry, class Value, class Number, class Sum>
[[gnu::always_inline]] inline void multiply_quad(const Quads::View& rows, const Value* value,
                                                 const Number* y, Index q, Sum* out) {
  const std::int32_t begin = rows.begin[q], end = rows.begin[q + 1];
  if (rows.gather[q] < 0)
    sum_entries<Entry>(InSequence<Number>{y, rows.column}, value, begin, end, out);
  else
    sum_entries<Entry>(Gathered<Number>{y, rows.gathered + rows.gather[q], begin, {}}, value, begin,
                       end, out);
}
template <class Entry>
[[gnu::always_inline]] inline void multiply(const Quads::View& rows, const float* value,
                                            const float* y, Index first, Index end, float* out) {
  for (Index q = first; q < end; ++q) multiply_quad<Entry>(rows, value, y, q, out + 16 * q);
}

/// The inverse of the diagonal is an entry a quad.
template <class Entry>
[[gnu::always_inline]] inline void smooth(const Smoothing& s, Index first, Index end, float* next) {
  if (s.x == nullptr) {
    for (Index q = first; q < end; ++q)
      store(s.damping * Entry::times(s.inverse + Entry::kNumbers * q, load<Quad>(s.f + 16 * q)),
            next + 16 * q);
    return;
  }
  for (Index q = first; q < end; ++q) {
    const Quad left = load<Quad>(s.f + 16 * q) - load<Quad>(s.product + 16 * q);
    store(
        load<Quad>(s.x + 16 * q) + s.damping * Entry::times(s.inverse + Entry::kNumbers * q, left),
        next + 16 * q);
  }
}

/// Two chains of sums of products.
[[gnu::always_inline]] inline double sum_of(const Pair& low, const Pair& high) {
  const Pair sum = low + high;
  return ((sum[0] + sum[4]) + (sum[1] + sum[5])) + (sum[2] + sum[6]);
}

}  // namespace

DEFORM_KERNEL void multiply_scalars(const Quads::View& rows, const float* value, const float* y,
                                    Index first, Index end, float* out) {
  multiply<ScalarEntry>(rows, value, y, first, end, out);
}
DEFORM_KERNEL void multiply_blocks(const Quads::View& rows, const float* value, const float* y,
                                   Index first, Index end, float* out) {
  multiply<BlockEntry>(rows, value, y, first, end, out);
}

DEFORM_KERNEL void multiply_scalars(const Quads::View& rows, const double* value, const float* y,
                                    Index first, Index end, float* out) {
  for (Index q = first; q < end; ++q) {
    double product[16];
    multiply_quad<ScalarEntry>(rows, value, y, q, product);
    for (Index i = 0; i < 16; ++i) out[16 * q + i] = static_cast<float>(product[i]);
  }
}
DEFORM_KERNEL void find_residual(const Quads::View& rows, const double* value, const double* x,
                                 const double* b, Index first, Index end, float* r) {
  for (Index q = first; q < end; ++q) {
    double product[16];
    multiply_quad<ScalarEntry>(rows, value, x, q, product);
    for (Index i = 0; i < 16; ++i) r[16 * q + i] = static_cast<float>(b[16 * q + i] - product[i]);
  }
}

DEFORM_KERNEL void smooth_scalars(const Smoothing& s, Index first, Index end, float* next) {
  smooth<ScalarEntry>(s, first, end, next);
}
DEFORM_KERNEL void smooth_blocks(const Smoothing& s, Index first, Index end, float* next) {
  smooth<BlockEntry>(s, first, end, next);
}

DEFORM_KERNEL double dot(const float* a, const float* b, Index first, Index end) {
  Pair low{}, high{};
  for (const float *x = a + 16 * first, *y = b + 16 * first; x < a + 16 * end; x += 16, y += 16) {
    low += __builtin_convertvector(load<HalfQuad>(x), Pair) *
           __builtin_convertvector(load<HalfQuad>(y), Pair);
    high += __builtin_convertvector(load<HalfQuad>(x + 8), Pair) *
            __builtin_convertvector(load<HalfQuad>(y + 8), Pair);
  }
  return sum_of(low, high);
}

DEFORM_KERNEL double dot(const double* a, const double* b, Index first, Index end) {
  Pair low{}, high{};
  for (const double *x = a + 16 * first, *y = b + 16 * first; x < a + 16 * end; x += 16, y += 16) {
    low += load<Pair>(x) * load<Pair>(y);
    high += load<Pair>(x + 8) * load<Pair>(y + 8);
  }
  return sum_of(low, high);
}

DEFORM_KERNEL void add(float factor, const float* from, Index first, Index end, float* to) {
  for (Index i = 16 * first; i < 16 * end; ++i) to[i] += factor * from[i];
}
DEFORM_KERNEL void add(float factor, const float* from, Index first, Index end, double* to) {
  for (Index i = 16 * first; i < 16 * end; ++i)
    to[i] += static_cast<double>(factor) * static_cast<double>(from[i]);
}
DEFORM_KERNEL void scale_and_add(float factor, const float* from, Index first, Index end,
                                 float* to) {
  for (Index i = 16 * first; i < 16 * end; ++i) to[i] = from[i] + factor * to[i];
}
}  // namespace multigrid
