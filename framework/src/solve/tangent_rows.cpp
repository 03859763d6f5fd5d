#include "solve/tangent_rows.h"

#include <cstring>

#include "deform/geometry/pairs.h"
#include "deform/kernel.h"

namespace deform {
namespace {

/// Numbers of eight rows. A vector by name: compilers would keep the sums below as single numbers.
using Numbers [[gnu::vector_size(64)]] = double;
constexpr int kNumbers = sizeof(Numbers) / sizeof(double);
constexpr int kVectors = kRowLanes / kNumbers;

[[gnu::always_inline]] inline void load(const double* from, Numbers& to) {
  std::memcpy(&to, from, sizeof to);
}
[[gnu::always_inline]] inline void store(const Numbers& from, double* to) {
  std::memcpy(to, &from, sizeof from);
}

/// Adds what one sample gives to entry (i, j) of the blocks of kRowLanes rows.
[[gnu::always_inline]] inline void add_sample(const TangentPlan& plan,
                                              const TangentPlan::Sample& at, const double* h, int i,
                                              int j, double* rows) {
  Numbers left[kDerivatives][kVectors];
  // By value: for all that a compiler knows, what is written below may be the plan's.
  const TangentPlan::Left *const lefts = plan.left.data(), *const lefts_end = lefts + at.left_end;
  const TangentPlan::Right *const rights = plan.right.data(), *const rights_end =
                                                                  rights + at.right_end;
  // Row a of Σ_m D_mᵀ A h_mn for each derivative n …
  for (const TangentPlan::Left* q = lefts + at.left; q != lefts_end; ++q) {
    const TangentPlan::Left part = *q;
    const int entry = part.is_transposed ? 3 * j + i : 3 * i + j;
    const double* block = h + (9 * part.block + entry) * kSampleLanes;
    for (int v = 0; v < kVectors; ++v) {
      Numbers numbers;
      load(block + v * kNumbers, numbers);
      numbers *= part.l;
      Numbers& sum = left[part.n][v];
      sum = part.is_first ? numbers : sum + numbers;
    }
  }
  // … times the rows of D_n at the sample.
  for (const TangentPlan::Right* q = rights + at.right; q != rights_end;) {
    const std::int16_t slot = q->slot;
    double* to = rows + (9 * slot + 3 * i + j) * kRowLanes;
    Numbers sum[kVectors];
    for (int v = 0; v < kVectors; ++v) load(to + v * kNumbers, sum[v]);
    for (; q != rights_end && q->slot == slot; ++q) {
      const double d = q->d;
      const Numbers* of_n = left[q->n];
      for (int v = 0; v < kVectors; ++v) sum[v] += d * of_n[v];
    }
    for (int v = 0; v < kVectors; ++v) store(sum[v], to + v * kNumbers);
  }
}

DEFORM_KERNEL void add_samples(const TangentPlan& plan, const double* h,
                               const std::uint32_t* places, double* rows) {
  for (std::size_t e = 0; e < plan.samples.size(); ++e)
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) add_sample(plan, plan.samples[e], h + places[e], i, j, rows);
}

/// Numbers of four rows, or four numbers of a row.
using Four [[gnu::vector_size(32)]] = double;

[[gnu::always_inline]] inline void load(const double* from, Four& to) {
  std::memcpy(&to, from, sizeof to);
}
/// Writes x, or adds it; 0 times what is there then, added up, is not 0 where some is not finite.
[[gnu::always_inline]] inline void put(const Four& x, double* to, bool adds, Four& zeros) {
  Four there{};
  if (adds) load(to, there);
  there += x;
  zeros += 0.0 * there;
  std::memcpy(to, &there, sizeof there);
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
      Four a, b, c, d;
      load(from, a);
      load(from + kRowLanes, b);
      load(from + 2 * kRowLanes, c);
      load(from + 3 * kRowLanes, d);
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

/// The same for one row: what is side by side are the entries of a block.
DEFORM_KERNEL void add_samples_of_one_row(const TangentPlan& plan, const double* h,
                                          const std::uint32_t* places, double* row) {
  for (std::size_t e = 0; e < plan.samples.size(); ++e) {
    const TangentPlan::Sample at = plan.samples[e];
    double left[kDerivatives][9];
    for (std::uint32_t q = at.left; q != at.left_end; ++q) {
      const TangentPlan::Left part = plan.left[q];
      const double* block = h + places[e] + 9 * part.block * kSampleLanes;
      double* sum = left[part.n];
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) {
          const int entry = part.is_transposed ? 3 * j + i : 3 * i + j;
          const double number = part.l * block[entry * kSampleLanes];
          sum[3 * i + j] = part.is_first ? number : sum[3 * i + j] + number;
        }
    }
    for (std::uint32_t q = at.right; q != at.right_end; ++q) {
      const TangentPlan::Right part = plan.right[q];
      double* to = row + 9 * part.slot;
      for (int k = 0; k < 9; ++k) to[k] += part.d * left[part.n][k];
    }
  }
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

/// 0 times what is there, added up, is not 0 where some is not finite.
DEFORM_KERNEL bool are_finite(const double* rows, Index size, Index numbers, Index lanes) {
  double zeros[kRowLanes]{};
  for (Index q = 0; q < numbers; ++q)
    for (Index k = 0; k < size; ++k) zeros[k] += 0.0 * rows[q * lanes + k];
  double zero = 0;
  for (Index k = 0; k < size; ++k) zero += zeros[k];
  return zero == 0;
}

}  // namespace

bool rows_are_finite(const double* rows, Index size, Index numbers, Index lanes) {
  return are_finite(rows, size, numbers, lanes);
}
void add_to_rows(const TangentPlan& plan, const double* h, const std::uint32_t* places,
                 double* rows) {
  add_samples(plan, h, places, rows);
}
bool store_rows(const double* rows, Index size, Index numbers, double* const* to, bool adds) {
  return move_rows(rows, size, numbers, to, adds);
}
void add_to_row(const TangentPlan& plan, const double* h, const std::uint32_t* places,
                double* row) {
  add_samples_of_one_row(plan, h, places, row);
}
bool store_row(const double* row, Index numbers, double* to, bool adds) {
  return move_row(row, numbers, to, adds);
}

}  // namespace deform
