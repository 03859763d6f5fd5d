#include "solve/tangent_assembler.h"

#include <algorithm>
#include <array>
#include <span>

#include "plugin/guard.h"

namespace deform {

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

void TangentAssembler::evaluate(const Geometries& geometries, Tangent kind,
                                const std::vector<double>& factors, Index first, Index size,
                                double* h, Index stride) const {
  std::fill_n(h, numbers() * stride, 0.0);
  const JetTangent tangent(h, stride, places_, size);
  const SampleBlock block = terms_->sample_block(geometries, first, size);
  thread_local std::vector<double> one;  // of a term that is multiplied
  for (const JetAssembler::Term& t : terms_->terms()) {
    const double factor = factors.empty() ? 1 : factors[t.number];
    if (!t.traits.potential || factor == 0) continue;
    if (factor == 1) {
      guarded(t.origin, "computing its tangent", [&] { t.term->tangent(block, kind, tangent); });
      continue;
    }
    one.assign(static_cast<std::size_t>(size * numbers()), 0.0);
    const JetTangent alone(one.data(), size, places_, size);
    guarded(t.origin, "computing its tangent", [&] { t.term->tangent(block, kind, alone); });
    for (Index q = 0; q < numbers(); ++q)
      for (Index s = 0; s < size; ++s)
        h[q * stride + s] += factor * one[static_cast<std::size_t>(q * size + s)];
  }
}

bool TangentAssembler::goes_on(Index a) const {
  if (blocks_.empty()) return true;
  if (terms_->gather().run_end(a) == a + 1) return false;
  return std::ranges::all_of(terms_->gather().row(a).samples,
                             [&](std::int32_t s) { return terms_->samples().run_end(s) > s + 1; });
}

void TangentAssembler::make_plan(const BlockMatrix& pattern, Index a, TangentPlan& plan,
                                 std::vector<std::int32_t>& samples) const {
  plan = {};
  if (blocks_.empty()) return;
  const auto columns_begin =
      pattern.column.begin() + pattern.row_begin[static_cast<std::size_t>(a)];
  const auto columns_end =
      pattern.column.begin() + pattern.row_begin[static_cast<std::size_t>(a) + 1];
  const GatherTable::Row row = terms_->gather().row(a);
  for (std::size_t e = 0; e < row.samples.size(); ++e) {
    const GatherTable::Coefficients& l = row.l[e];
    TangentPlan::Sample at{static_cast<std::uint32_t>(plan.left.size()), 0,
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
    for (std::size_t b = 0; b < stencil.nodes.size(); ++b) {
      const auto column = std::lower_bound(columns_begin, columns_end, stencil.nodes[b]);
      if (column == columns_end || *column != stencil.nodes[b]) continue;  // of the lower half
      for (const int n : derivatives_)
        if (const double d = stencil.d[b][static_cast<std::size_t>(n)];
            d != 0 && has_part[static_cast<std::size_t>(n)])
          plan.right.push_back(
              {static_cast<std::int16_t>(n), static_cast<std::int16_t>(column - columns_begin), d});
    }
    at.left_end = static_cast<std::uint32_t>(plan.left.size());
    at.right_end = static_cast<std::uint32_t>(plan.right.size());
    if (at.left == at.left_end || at.right == at.right_end) continue;
    plan.samples.push_back(at);
    samples.push_back(row.samples[e]);
  }
}

}  // namespace deform
