#include "solve/tangent_assembler.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <span>

#include "deform/parallel.h"

#include "parallel/kernel.h"
#include "plugin/guard.h"

namespace deform {
namespace {

/// Rows that one task gathers, a multiple of TangentAssembler::kLanes.
constexpr Index kRows = 64;
/// A few rows are gathered one by one; so many, as one group with lanes that are not used.
constexpr Index kFewest = 4;

using Plan = TangentAssembler::Plan;

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
[[gnu::always_inline]] inline void add_sample(const Plan& plan, const Plan::Sample& at,
                                              const double* h, Index stride, double* rows) {
  using Numbers = typename Rows::Numbers;
  constexpr int kNumbers = sizeof(Numbers) / sizeof(double);
  Numbers left[kDerivatives][Vectors];
  // By value: for all that a compiler knows, what is written below may be the plan's.
  const Plan::Left *const lefts = plan.left.data(), *const lefts_end = lefts + at.left_end;
  const Plan::Right *const rights = plan.right.data(), *const rights_end = rights + at.right_end;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      // Row a of Σ_m D_mᵀ A h_mn for each derivative n …
      for (const Plan::Left* q = lefts + at.left; q != lefts_end; ++q) {
        const Plan::Left part = *q;
        const int entry = part.is_transposed ? 3 * j + i : 3 * i + j;
        const double* block = h + (9 * part.block + entry) * stride;
        for (int v = 0; v < Vectors; ++v) {
          Numbers numbers;
          copy(block + v * kNumbers, numbers);
          numbers *= part.l;
          Numbers& sum = left[part.n][v];
          sum = part.is_first ? numbers : sum + numbers;
        }
      }
      // … times the rows of D_n at the sample.
      for (const Plan::Right* q = rights + at.right; q != rights_end;) {
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

DEFORM_KERNEL void add_samples(const Plan& plan, const double* h, Index stride, double* rows) {
  for (const Plan::Sample& at : plan.samples)
    add_sample<EightRows, TangentAssembler::kLanes / 8>(plan, at, h + at.sample, stride, rows);
}
DEFORM_KERNEL void add_samples_of_one_row(const Plan& plan, const double* h, Index stride,
                                          double* rows) {
  for (const Plan::Sample& at : plan.samples)
    add_sample<OneRow, 1>(plan, at, h + at.sample, stride, rows);
}

std::int32_t row_size(const BlockMatrix& k, Index a) {
  return k.row_begin[static_cast<std::size_t>(a) + 1] - k.row_begin[static_cast<std::size_t>(a)];
}

}  // namespace

TangentAssembler::TangentAssembler(const JetAssembler& terms) : terms_(&terms) {
  for (const JetAssembler::Term& t : terms.terms()) {
    if (!t.traits.potential) continue;
    for (const Derivative d :
         guarded(t.origin, "saying what it depends on", [&] { return t.term->dependence(); }))
      if (slot(d) > 0 && slot(d) < kDerivatives &&
          std::ranges::find(derivatives_, slot(d)) == derivatives_.end())
        derivatives_.push_back(slot(d));
  }
  std::ranges::sort(derivatives_);
  for (auto& row : places_) row.fill(-1);
  for (const int m : derivatives_)
    for (const int n : derivatives_)
      if (m <= n) {
        places_[static_cast<std::size_t>(m)][static_cast<std::size_t>(n)] =
            static_cast<std::int16_t>(blocks_.size());
        blocks_.push_back({m, n});
      }
}

bool TangentAssembler::depends(const std::array<double, kDerivatives>& d) const {
  return std::ranges::any_of(derivatives_,
                             [&](int m) { return d[static_cast<std::size_t>(m)] != 0; });
}
bool TangentAssembler::depends(const GatherTable::Coefficients& l) const {
  return std::ranges::any_of(derivatives_,
                             [&](int m) { return l[static_cast<std::size_t>(m)] != 0; });
}

void TangentAssembler::bind(const BlockMatrix& pattern) {
  const GatherTable& gather = terms_->gather();
  h_.resize(static_cast<std::size_t>(terms_->samples().stride()) * blocks_.size() * 9 + kLanes);
  slot_begin_.clear();
  slot_.clear();
  run_end_.assign(static_cast<std::size_t>(gather.nodes()),
                  static_cast<std::int32_t>(gather.nodes()));
  if (blocks_.empty()) return;
  for (Index a = 0; a < gather.nodes(); ++a) {
    const auto begin = pattern.column.begin() + pattern.row_begin[static_cast<std::size_t>(a)];
    const auto end = pattern.column.begin() + pattern.row_begin[static_cast<std::size_t>(a) + 1];
    for (const std::int32_t s : gather.row(a).samples) {
      slot_begin_.push_back(slot_.size());
      for (const std::int32_t b : terms_->samples().stencil(s).nodes) {
        const auto at = std::lower_bound(begin, end, b);
        const bool is_there = b >= a && at != end && *at == b;
        slot_.push_back(is_there ? static_cast<std::uint16_t>(at - begin) : kNoSlot);
      }
    }
  }
  for (Index a = gather.nodes() - 1; a >= 0; --a) {
    const bool is_last = a + 1 == gather.nodes() || !goes_on(a);
    run_end_[static_cast<std::size_t>(a)] =
        is_last ? static_cast<std::int32_t>(a + 1) : run_end_[static_cast<std::size_t>(a) + 1];
  }
}

bool TangentAssembler::goes_on(Index a) const {
  const GatherTable& gather = terms_->gather();
  if (gather.run_end(a) == a + 1) return false;
  const std::span<const std::int32_t> samples = gather.row(a).samples;
  for (std::size_t e = 0; e < samples.size(); ++e) {
    if (terms_->samples().run_end(samples[e]) == samples[e] + 1) return false;
    const auto width =
        static_cast<std::ptrdiff_t>(terms_->samples().stencil(samples[e]).nodes.size());
    const auto slots =
        slot_.begin() + static_cast<std::ptrdiff_t>(slot_begin_[gather.first_pair(a) + e]);
    const auto next =
        slot_.begin() + static_cast<std::ptrdiff_t>(slot_begin_[gather.first_pair(a + 1) + e]);
    if (!std::equal(slots, slots + width, next)) return false;
  }
  return true;
}

void TangentAssembler::evaluate(const Geometries& geometries, Tangent kind,
                                const std::vector<double>& factors) {
  if (blocks_.empty()) return;
  const Index stride = terms_->samples().stride(), numbers = static_cast<Index>(blocks_.size()) * 9;
  parallel_blocks(terms_->samples().size(), kBlock, [&](Index first, Index size) {
    for (Index q = 0; q < numbers; ++q) std::fill_n(h_.data() + q * stride + first, size, 0.0);
    const JetTangent tangent(h_.data() + first, stride, places_, size);
    const SampleBlock block = terms_->sample_block(geometries, first, size);
    std::vector<double> one;  // of a term that is multiplied
    for (const JetAssembler::Term& t : terms_->terms()) {
      const double factor = factors.empty() ? 1 : factors[t.number];
      if (!t.traits.potential || factor == 0) continue;
      if (factor == 1) {
        guarded(t.origin, "computing its tangent", [&] { t.term->tangent(block, kind, tangent); });
        continue;
      }
      one.assign(static_cast<std::size_t>(size * numbers), 0.0);
      const JetTangent alone(one.data(), size, places_, size);
      guarded(t.origin, "computing its tangent", [&] { t.term->tangent(block, kind, alone); });
      for (Index q = 0; q < numbers; ++q)
        for (Index s = 0; s < size; ++s)
          h_[static_cast<std::size_t>(q * stride + first + s)] +=
              factor * one[static_cast<std::size_t>(q * size + s)];
    }
  });
}

void TangentAssembler::make_plan(Index a, Plan& plan) const {
  plan.row = a;
  plan.left.clear(), plan.right.clear(), plan.samples.clear();
  if (blocks_.empty()) return;
  const GatherTable& gather = terms_->gather();
  const GatherTable::Row row = gather.row(a);
  for (std::size_t e = 0; e < row.samples.size(); ++e) {
    const GatherTable::Coefficients& l = row.l[e];
    Plan::Sample at{row.samples[e], static_cast<std::uint32_t>(plan.left.size()), 0,
                    static_cast<std::uint32_t>(plan.right.size()), 0};
    std::array<bool, kDerivatives> has_part{};
    const auto add = [&](int n, std::size_t block, bool is_transposed, double factor) {
      if (factor == 0) return;
      bool& has = has_part[static_cast<std::size_t>(n)];
      plan.left.push_back({static_cast<std::int16_t>(n), static_cast<std::int16_t>(block),
                           is_transposed, !has, factor});
      has = true;
    };
    for (std::size_t q = 0; q < blocks_.size(); ++q) {
      const auto& [m, n] = blocks_[q];
      add(n, q, false, l[static_cast<std::size_t>(m)]);
      if (m != n) add(m, q, true, l[static_cast<std::size_t>(n)]);
    }
    const SampleSet::Stencil stencil = terms_->samples().stencil(row.samples[e]);
    const std::uint16_t* slots = slot_.data() + slot_begin_[gather.first_pair(a) + e];
    for (std::size_t b = 0; b < stencil.nodes.size(); ++b) {
      if (slots[b] == kNoSlot) continue;
      for (const int n : derivatives_)
        if (const double d = stencil.d[b][static_cast<std::size_t>(n)];
            d != 0 && has_part[static_cast<std::size_t>(n)])
          plan.right.push_back(
              {static_cast<std::int16_t>(n), static_cast<std::int16_t>(slots[b]), d});
    }
    at.left_end = static_cast<std::uint32_t>(plan.left.size());
    at.right_end = static_cast<std::uint32_t>(plan.right.size());
    if (at.left != at.left_end && at.right != at.right_end) plan.samples.push_back(at);
  }
}

void TangentAssembler::accumulate(const Plan& plan, Index a, Index width, double* rows) const {
  const double* h = h_.data() + (a - plan.row);
  const Index stride = terms_->samples().stride();
  if (width == 1)
    add_samples_of_one_row(plan, h, stride, rows);
  else
    add_samples(plan, h, stride, rows);
}

namespace {

/// Rows a … a+size−1, which are alike in all sets.
void gather_run(const std::vector<TangentAssembler>& sets, const std::vector<Plan>& plans, Index a,
                Index size, bool adds, std::vector<double>& rows, BlockMatrix& k) {
  const Index width = size < kFewest ? 1 : TangentAssembler::kLanes;
  const auto begin = static_cast<std::size_t>(a);
  const Index numbers = 9 * Index{k.row_begin[begin + 1] - k.row_begin[begin]};
  for (Index done = 0; done < size; done += width) {
    rows.assign(static_cast<std::size_t>(numbers * width), 0.0);
    for (std::size_t i = 0; i < sets.size(); ++i)
      sets[i].accumulate(plans[i], a + done, width, rows.data());
    for (Index q = 0; q < std::min(width, size - done); ++q) {
      double* to = k.value.data() + 9 * Index{k.row_begin[static_cast<std::size_t>(a + done + q)]};
      for (Index i = 0; i < numbers; ++i)
        to[i] = (adds ? to[i] : 0) + rows[static_cast<std::size_t>(i * width + q)];
    }
  }
}

}  // namespace

void gather_tangents(const std::vector<TangentAssembler>& sets, BlockMatrix& k, bool adds) {
  parallel_blocks(k.nodes, kRows, [&](Index first, Index size) {
    // Kept by each thread from call to call: no allocation once they are large enough.
    thread_local std::vector<Plan> plans;
    thread_local std::vector<double> rows;
    plans.resize(std::max(plans.size(), sets.size()));
    for (Index a = first; a < first + size;) {
      Index end = first + size;
      for (std::size_t i = 0; i < sets.size(); ++i) {
        sets[i].make_plan(a, plans[i]);
        end = std::min(end, sets[i].run_end(a));
      }
      // What no set knows of (springs, say) may make rows longer.
      for (Index b = a + 1; b < end; ++b)
        if (row_size(k, b) != row_size(k, a)) end = b;
      gather_run(sets, plans, a, end - a, adds, rows, k);
      a = end;
    }
  });
}

}  // namespace deform
