#include "solve/tangent_rows.h"

#include <cstring>

#include "deform/geometry/pairs.h"

#include "parallel/kernel.h"

namespace deform {
namespace {

/// Numbers of eight rows, and of one. Vectors by name: compilers would keep the sums below as
/// single numbers.
struct EightRows {
  using Numbers [[gnu::vector_size(64)]] = double;
};
struct OneRow {
  using Numbers = double;
};

template <class Numbers>
[[gnu::always_inline]] inline void copy(const double* from, Numbers& to) {
  std::memcpy(&to, from, sizeof to);
}
template <class Numbers>
[[gnu::always_inline]] inline void copy(const Numbers& from, double* to) {
  std::memcpy(to, &from, sizeof from);
}

/// Adds what one sample gives to `Vectors` times as many rows as `Rows` has.
template <class Rows, int Vectors>
[[gnu::always_inline]] inline void add_sample(const TangentPlan& plan,
                                              const TangentPlan::Sample& at, const double* h,
                                              double* rows) {
  using Numbers = typename Rows::Numbers;
  constexpr int kNumbers = sizeof(Numbers) / sizeof(double);
  Numbers left[kDerivatives][Vectors];
  // By value: for all that a compiler knows, what is written below may be the plan's.
  const TangentPlan::Left *const lefts = plan.left.data(), *const lefts_end = lefts + at.left_end;
  const TangentPlan::Right *const rights = plan.right.data(), *const rights_end =
                                                                  rights + at.right_end;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      // Row a of Σ_m D_mᵀ A h_mn for each derivative n …
      for (const TangentPlan::Left* q = lefts + at.left; q != lefts_end; ++q) {
        const TangentPlan::Left part = *q;
        const int entry = part.is_transposed ? 3 * j + i : 3 * i + j;
        const double* block = h + (9 * part.block + entry) * kSampleLanes;
        for (int v = 0; v < Vectors; ++v) {
          Numbers numbers;
          copy(block + v * kNumbers, numbers);
          numbers *= part.l;
          Numbers& sum = left[part.n][v];
          sum = part.is_first ? numbers : sum + numbers;
        }
      }
      // … times the rows of D_n at the sample.
      for (const TangentPlan::Right* q = rights + at.right; q != rights_end;) {
        const std::int16_t slot = q->slot;
        double* to = rows + (9 * slot + 3 * i + j) * Vectors * kNumbers;
        Numbers sum[Vectors];
        for (int v = 0; v < Vectors; ++v) copy(to + v * kNumbers, sum[v]);
        for (; q != rights_end && q->slot == slot; ++q) {
          const double d = q->d;
          const Numbers* of_n = left[q->n];
          for (int v = 0; v < Vectors; ++v) sum[v] += d * of_n[v];
        }
        for (int v = 0; v < Vectors; ++v) copy(sum[v], to + v * kNumbers);
      }
    }
}

DEFORM_KERNEL void add_samples(const TangentPlan& plan, const double* h,
                               const std::uint32_t* places, double* rows) {
  for (std::size_t e = 0; e < plan.samples.size(); ++e)
    add_sample<EightRows, kRowLanes / 8>(plan, plan.samples[e], h + places[e], rows);
}
DEFORM_KERNEL void add_samples_of_one_row(const TangentPlan& plan, const double* h,
                                          const std::uint32_t* places, double* row) {
  for (std::size_t e = 0; e < plan.samples.size(); ++e)
    add_sample<OneRow, 1>(plan, plan.samples[e], h + places[e], row);
}

}  // namespace

void add_to_rows(const TangentPlan& plan, const double* h, const std::uint32_t* places,
                 double* rows) {
  add_samples(plan, h, places, rows);
}
void add_to_row(const TangentPlan& plan, const double* h, const std::uint32_t* places,
                double* row) {
  add_samples_of_one_row(plan, h, places, row);
}

}  // namespace deform
