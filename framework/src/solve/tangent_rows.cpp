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
