#include "runs.h"

#include <algorithm>
#include <map>
#include <tuple>

#include <deform/kernel.h>

namespace multigrid {
namespace {

/// Rows that one task has, at least.
constexpr Index kRowsOfTask = 1024;
/// Rows of a run whose sums are kept at a time.
constexpr Index kSums = 64;

template <Index column_step>
[[gnu::always_inline]] inline void sum_shares(const AlikeRows::Entry* share,
                                              const AlikeRows::Entry* end, const float* x,
                                              Index size, float* sum) {
  for (Index i = 0; i < size; ++i) sum[i] = 0;
  for (; share != end; ++share) {
    const float weight = share->weight;
    const float* const from = x + share->column;
#pragma GCC ivdep
    for (Index i = 0; i < size; ++i) sum[i] += weight * from[column_step * i];
  }
}

template <Index row_step>
[[gnu::always_inline]] inline void put(const float* sum, Index size, float* y, bool adds) {
#pragma GCC ivdep
  for (Index i = 0; i < size; ++i) y[row_step * i] = (adds ? y[row_step * i] : 0) + sum[i];
}

/// One component.
DEFORM_KERNEL void multiply_run(const Runs::Run& of, const AlikeRows::Entry* share,
                                const AlikeRows::Entry* end, const float* x, float* y, bool adds) {
  const Runs::Run run = of;
  float sum[kSums];
  for (Index first = 0; first < run.size; first += kSums) {
    const Index size = std::min<Index>(kSums, run.size - first);
    const float* const from = x + run.column + run.column_step * first;
    if (run.column_step == 2)
      sum_shares<2>(share, end, from, size, sum);
    else
      sum_shares<1>(share, end, from, size, sum);
    float* const to = y + run.row + run.row_step * first;
    if (run.row_step == 2)
      put<2>(sum, size, to, adds);
    else
      put<1>(sum, size, to, adds);
  }
}

}  // namespace

Runs::Runs(const AlikeRows& rows) {
  take_runs(rows);
  make_tasks();
}

/// The rows from one on that follow by one or by two, whichever are more.
Runs::Run Runs::longest_run(const AlikeRows& rows, std::int32_t row,
                            const std::vector<bool>& is_taken) const {
  Run longest{row, 1, 1, rows.first(row), 1, 0, 0};
  for (const std::int32_t step : {1, 2}) {
    const auto goes_on = [&](std::int32_t a) {
      const Index next = Index{a} + step;
      return next < rows.rows() && !is_taken[static_cast<std::size_t>(next)] &&
             rows.are_alike(a, next);
    };
    if (!goes_on(row)) continue;
    const std::int32_t column_step = rows.first(row + step) - rows.first(row);
    if (column_step != 1 && column_step != 2) continue;
    std::int32_t last = row;
    while (goes_on(last) && rows.first(last + step) - rows.first(last) == column_step) last += step;
    const std::int32_t size = (last - row) / step + 1;
    if (size > longest.size) longest = {row, step, size, rows.first(row), column_step, 0, 0};
  }
  return longest;
}

void Runs::take_runs(const AlikeRows& rows) {
  std::vector<bool> is_taken(static_cast<std::size_t>(rows.rows()));
  std::map<const AlikeRows::Entry*, std::pair<std::uint32_t, std::uint32_t>> known;
  for (std::int32_t a = 0; a < rows.rows(); ++a) {
    if (is_taken[static_cast<std::size_t>(a)]) continue;
    Run run = longest_run(rows, a, is_taken);
    for (std::int32_t i = 0; i < run.size; ++i)
      is_taken[static_cast<std::size_t>(a + Index{run.row_step} * i)] = true;
    const std::span<const AlikeRows::Entry> shared = rows.shared(a);
    const auto begin = static_cast<std::uint32_t>(shares_.size());
    const auto [at, is_new] =
        known.try_emplace(shared.data(), begin, begin + static_cast<std::uint32_t>(shared.size()));
    if (is_new) shares_.insert(shares_.end(), shared.begin(), shared.end());
    std::tie(run.share, run.share_end) = at->second;
    runs_.push_back(run);
  }
}

/// Runs come in ascending order of their first rows; a task ends where none goes on.
void Runs::make_tasks() {
  Index end = 0;
  for (std::size_t r = 0; r < runs_.size(); ++r) {
    const Run& run = runs_[r];
    const bool is_full = !tasks_.empty() && end - tasks_.back().row >= kRowsOfTask;
    if (tasks_.empty() || (is_full && run.row >= end)) tasks_.push_back({run.row, 0, r, r});
    end = std::max<Index>(end, run.row + run.row_step * (run.size - 1) + 1);
    tasks_.back().size = end - tasks_.back().row;
    tasks_.back().run_end = r + 1;
  }
}

void Runs::multiply(const Task& task, const Field<float>& x, Field<float>& y, bool adds) const {
  for (std::size_t r = task.run; r < task.run_end; ++r) {
    const Run& run = runs_[r];
    for (Index c = 0; c < 3; ++c)
      multiply_run(run, shares_.data() + run.share, shares_.data() + run.share_end, x.data(c),
                   y.data(c), adds);
  }
}

}  // namespace multigrid
