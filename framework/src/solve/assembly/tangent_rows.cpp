#include "solve/assembly/tangent_rows.h"

#include <algorithm>
#include <cstring>

#include "deform/geometry/pairs.h"
#include "deform/kernel.h"

// Vectors pass between functions that are all inlined.
#pragma GCC diagnostic ignored "-Wpsabi"

namespace deform {
namespace {

/// Numbers of several rows. Vectors by name: compilers would keep the sums below as single numbers.
template <int bytes>
struct NumbersOf {
  using Type [[gnu::vector_size(bytes)]] = double;
};
/// Rows that are made at once, at most.
constexpr std::size_t kMostLanes = 8;

/// What is done for numbers of a row: those of several rows side by side, or of a row alone, are a
/// vector. At h, numbers lie kSampleLanes apart.
template <class Number>
[[gnu::always_inline]] inline Number load(const double* from) {
  Number x;
  std::memcpy(&x, from, sizeof x);
  return x;
}
template <class Number>
[[gnu::always_inline]] inline void store(const Number& x, double* to) {
  std::memcpy(to, &x, sizeof x);
}
template <class Number>
inline constexpr Index kLanes = sizeof(Number) / sizeof(double);

/// Entry k, row by row, of a block or of its transpose.
[[gnu::always_inline]] inline int entry(int k, bool is_transposed) {
  return is_transposed ? 3 * (k % 3) + k / 3 : k;
}

/// Parts of blocks, nine numbers each.
template <class Number>
[[gnu::always_inline]] inline void make_parts(const TangentPlan& plan, const double* h,
                                              const std::uint32_t* places, double* parts) {
  const TangentPlan::Left* left = plan.left.data();
  for (const TangentPlan::Part *p = plan.parts.data(), *end = p + plan.parts.size(); p != end;
       ++p) {
    const double* const at = h + places[p->sample];
    Number sum[9]{};
    for (const TangentPlan::Left* const last = plan.left.data() + p->left_end; left != last;
         ++left) {
      const double* const block = at + Index{9} * left->block * kSampleLanes;
      if (left->is_transposed)
        for (int k = 0; k < 9; ++k)
          sum[k] += left->l * load<Number>(block + entry(k, true) * kSampleLanes);
      else
        for (int k = 0; k < 9; ++k) sum[k] += left->l * load<Number>(block + k * kSampleLanes);
    }
    for (int k = 0; k < 9; ++k, parts += kLanes<Number>) store(sum[k], parts);
  }
}

/// Blocks of the row from these, number q of the row at rows[q · stride]; adds 0 times each to
/// `zeros`, which is not 0 then where some is not finite.
template <class Number>
[[gnu::always_inline]] inline void make_blocks(const TangentPlan& plan, const double* parts,
                                               bool adds, double* rows, Index stride,
                                               Number& zeros) {
  const TangentPlan::Right* right = plan.right.data();
  for (const std::uint32_t end : plan.right_end) {
    Number sum[9]{};
    if (adds)
      for (int k = 0; k < 9; ++k) sum[k] = load<Number>(rows + k * stride);
    for (const TangentPlan::Right* const last = plan.right.data() + end; right != last; ++right) {
      const double* const part = parts + Index{9} * right->part * kLanes<Number>;
      for (int k = 0; k < 9; ++k) sum[k] += right->d * load<Number>(part + k * kLanes<Number>);
    }
    for (int k = 0; k < 9; ++k, rows += stride) {
      zeros += 0.0 * sum[k];
      store(sum[k], rows);
    }
  }
}

/// Parts of multiples of n nᵀ or I, one number each.
template <class Number>
[[gnu::always_inline]] inline double* make_factor_parts(const TangentPlan& plan,
                                                        const SampleNumbers& of, Index lane,
                                                        double* parts) {
  const TangentPlan::Left* left = plan.left.data();
  for (const TangentPlan::Part *p = plan.parts.data(), *end = p + plan.parts.size(); p != end;
       ++p) {
    const double* const at = of.h + of.places[p->sample] + lane;
    Number sum{};
    for (const TangentPlan::Left* const last = plan.left.data() + p->left_end; left != last; ++left)
      sum += left->l * load<Number>(at + left->block * kSampleLanes);
    store(sum, parts);
    parts += kLanes<Number>;
  }
  return parts;
}

/// Behind these the six of n nᵀ of each sample.
template <class Number>
[[gnu::always_inline]] inline void make_normals(const TangentPlan& plan, const SampleNumbers& of,
                                                Index lane, double* parts) {
  for (std::size_t e = 0; e < plan.samples; ++e) {
    const double* const n = of.h + of.places[e] + lane + of.blocks * kSampleLanes;
    const auto x = load<Number>(n), y = load<Number>(n + kSampleLanes),
               z = load<Number>(n + 2 * kSampleLanes);
    for (const Number& product : {x * x, x * y, x * z, y * y, y * z, z * z}) {
      store(product, parts);
      parts += kLanes<Number>;
    }
  }
}

template <class Number>
[[gnu::always_inline]] inline void make_normal_blocks(const TangentPlan& plan, const double* parts,
                                                      bool adds, double* rows, Index stride,
                                                      Number& zeros) {
  static constexpr int kOfEntry[9] = {0, 1, 2, 1, 3, 4, 2, 4, 5};
  const double* const normals = parts + static_cast<Index>(plan.parts.size()) * kLanes<Number>;
  const TangentPlan::Right* right = plan.right.data();
  for (const std::uint32_t end : plan.right_end) {
    Number sum[6]{};
    for (const TangentPlan::Right* const last = plan.right.data() + end; right != last;) {
      const std::uint32_t sample = plan.parts[right->part].sample;
      Number factor{};
      for (; right != last && plan.parts[right->part].sample == sample; ++right)
        factor += right->d * load<Number>(parts + right->part * kLanes<Number>);
      const double* const n = normals + Index{6} * sample * kLanes<Number>;
      for (int k = 0; k < 6; ++k) sum[k] += factor * load<Number>(n + k * kLanes<Number>);
    }
    for (int k = 0; k < 9; ++k, rows += stride) {
      Number whole = sum[kOfEntry[k]];
      if (adds) whole += load<Number>(rows);
      zeros += 0.0 * whole;
      store(whole, rows);
    }
  }
}

/// Blocks that are multiples of I.
template <class Number>
[[gnu::always_inline]] inline void make_identity_blocks(const TangentPlan& plan,
                                                        const double* parts, bool adds,
                                                        double* rows, Index stride, Number& zeros) {
  const TangentPlan::Right* right = plan.right.data();
  for (const std::uint32_t end : plan.right_end) {
    Number sum{};
    for (const TangentPlan::Right* const last = plan.right.data() + end; right != last; ++right)
      sum += right->d * load<Number>(parts + right->part * kLanes<Number>);
    zeros += 0.0 * sum;
    for (int k = 0; k < 9; ++k, rows += stride) {
      Number whole{};
      if (adds) whole = load<Number>(rows);
      if (k % 4 == 0) whole += sum;
      if (adds) zeros += 0.0 * whole;
      store(whole, rows);
    }
  }
}

/// Rows from a lane on; returns what is 0 for each that is finite.
template <class Number>
[[gnu::always_inline]] inline Number make(const TangentPlan& plan, const SampleNumbers& of,
                                          bool adds, Index lane, double* room, double* rows,
                                          Index stride) {
  Number zeros{};
  if (of.shape == TangentShape::blocks) {
    make_parts<Number>(plan, of.h + lane, of.places, room);
    make_blocks<Number>(plan, room, adds, rows + lane, stride, zeros);
    return zeros;
  }
  double* const behind = make_factor_parts<Number>(plan, of, lane, room);
  if (of.shape == TangentShape::identity) {
    make_identity_blocks<Number>(plan, room, adds, rows + lane, stride, zeros);
  } else {
    make_normals<Number>(plan, of, lane, behind);
    make_normal_blocks<Number>(plan, room, adds, rows + lane, stride, zeros);
  }
  return zeros;
}

/// What lanes beyond `size` have is nobody's.
template <int bytes>
[[gnu::always_inline]] inline bool make_rows_side_by_side_by(const TangentPlan& plan,
                                                             const SampleNumbers& of, bool adds,
                                                             Index size, double* room,
                                                             double* rows) {
  using Numbers = typename NumbersOf<bytes>::Type;
  double zero = 0;
  for (Index lane = 0; lane < size; lane += kLanes<Numbers>) {
    const auto zeros = make<Numbers>(plan, of, adds, lane, room, rows, kRowLanes);
    for (Index k = 0; k < std::min(kLanes<Numbers>, size - lane); ++k) zero += zeros[k];
  }
  return zero == 0;
}

}  // namespace

DEFORM_VECTOR_KERNEL(static bool, make_rows_side_by_side,
                     (const TangentPlan& plan, const SampleNumbers& of, bool adds, Index size,
                      double* room, double* rows),
                     (plan, of, adds, size, room, rows))

namespace {

/// Numbers of four rows, or four numbers of a row.
using Four [[gnu::vector_size(32)]] = double;

/// Writes x, or adds it; 0 times what is there then, added up, is not 0 where some is not finite.
[[gnu::always_inline]] inline void put(const Four& x, double* to, bool adds, Four& zeros) {
  Four there{};
  if (adds) there = load<Four>(to);
  there += x;
  zeros += 0.0 * there;
  store(there, to);
}

DEFORM_KERNEL bool move_rows(const double* rows, Index size, Index numbers, double* const* to,
                             bool adds) {
  Four zeros{};
  double zero = 0;
  const auto put_one = [&](Index i, Index q) {
    double& place = to[q][i];
    place = (adds ? place : 0) + rows[i * kRowLanes + q];
    zero += 0.0 * place;
  };
  const Index whole = numbers / 4 * 4;
  Index q = 0;
  for (; q + 4 <= size; q += 4) {
    for (Index i = 0; i < whole; i += 4) {
      const double* from = rows + i * kRowLanes + q;
      const Four a = load<Four>(from), b = load<Four>(from + kRowLanes),
                 c = load<Four>(from + 2 * kRowLanes), d = load<Four>(from + 3 * kRowLanes);
      const Four ab_even = __builtin_shufflevector(a, b, 0, 4, 2, 6),
                 ab_odd = __builtin_shufflevector(a, b, 1, 5, 3, 7),
                 cd_even = __builtin_shufflevector(c, d, 0, 4, 2, 6),
                 cd_odd = __builtin_shufflevector(c, d, 1, 5, 3, 7);
      put(__builtin_shufflevector(ab_even, cd_even, 0, 1, 4, 5), to[q] + i, adds, zeros);
      put(__builtin_shufflevector(ab_odd, cd_odd, 0, 1, 4, 5), to[q + 1] + i, adds, zeros);
      put(__builtin_shufflevector(ab_even, cd_even, 2, 3, 6, 7), to[q + 2] + i, adds, zeros);
      put(__builtin_shufflevector(ab_odd, cd_odd, 2, 3, 6, 7), to[q + 3] + i, adds, zeros);
    }
    for (Index i = whole; i < numbers; ++i)
      for (Index k = 0; k < 4; ++k) put_one(i, q + k);
  }
  for (; q < size; ++q)
    for (Index i = 0; i < numbers; ++i) put_one(i, q);
  return zeros[0] + zeros[1] + zeros[2] + zeros[3] + zero == 0;
}

DEFORM_KERNEL bool move_row(const double* __restrict row, Index numbers, double* __restrict to,
                            bool adds) {
  bool is_finite = true;
  for (Index i = 0; i < numbers; ++i) {
    to[i] = (adds ? to[i] : 0) + row[i];
    is_finite &= 0.0 * to[i] == 0;
  }
  return is_finite;
}

}  // namespace

std::size_t room_for(const TangentPlan& plan) {
  const std::size_t of_blocks = 9 * plan.parts.size(),
                    of_normals = plan.parts.size() + 6 * plan.samples;
  return std::max(of_blocks, of_normals) * kMostLanes;
}
bool make_rows(const TangentPlan& plan, const SampleNumbers& of, bool adds, Index size,
               double* room, double* rows) {
  return make_rows_side_by_side(plan, of, adds, size, room, rows);
}
bool make_row(const TangentPlan& plan, const SampleNumbers& of, bool adds, double* room,
              double* row) {
  return make<double>(plan, of, adds, 0, room, row, 1) == 0;
}
bool store_rows(const double* rows, Index size, Index numbers, double* const* to, bool adds) {
  return move_rows(rows, size, numbers, to, adds);
}
bool store_row(const double* row, Index numbers, double* to, bool adds) {
  return move_row(row, numbers, to, adds);
}

}  // namespace deform
