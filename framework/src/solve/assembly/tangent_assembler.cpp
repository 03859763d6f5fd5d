#include "solve/assembly/tangent_assembler.h"

#include <algorithm>
#include <array>
#include <span>
#include <vector>

#include "plugin/guard.h"

namespace deform {

bool TangentAssembler::has_tangent(const JetAssembler::Term& term) {
  return term.traits.potential || !term.traits.strong_form ||
         guarded(term.origin, "saying what its tangent is", [&] {
           return term.term->tangent_shape(Tangent::projected);
         }) != TangentShape::blocks;
}

Tangent TangentAssembler::kind_of(const JetAssembler::Term& term, Tangent kind) {
  return term.traits.potential ? kind : Tangent::projected;
}

TangentAssembler::TangentAssembler(const JetAssembler& terms) : terms_(&terms) {
  for (const JetAssembler::Term& t : terms.terms()) {
    if (!has_tangent(t)) continue;
    with_tangent_.push_back(&t);
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

TangentShape TangentAssembler::shape(Tangent kind) const {
  const auto of = [&](const JetAssembler::Term* t) {
    return guarded(t->origin, "saying what its tangent is",
                   [&] { return t->term->tangent_shape(kind_of(*t, kind)); });
  };
  if (with_tangent_.empty()) return TangentShape::identity;
  const TangentShape one = of(with_tangent_.front());
  return std::ranges::all_of(with_tangent_, [&](const auto* t) { return of(t) == one; })
             ? one
             : TangentShape::blocks;
}

void TangentAssembler::evaluate_term(const JetAssembler::Term& term, const SampleBlock& block,
                                     Tangent kind, const Numbers& to) const {
  guarded(term.origin, "computing its tangent", [&] {
    const Tangent own = kind_of(term, kind);
    if (to.shape == TangentShape::blocks)
      term.term->tangent(block, own, JetTangent(to.h, to.stride, places_, to.size));
    else
      term.term->tangent_factors(block, own, TangentFactors(to.h, to.stride, places_, to.size));
  });
}

void TangentAssembler::evaluate(const Geometries& geometries, Tangent kind,
                                const std::vector<double>& factors, Index first, Index size,
                                TangentShape shape, double* h, Index stride) const {
  const Index count = shape == TangentShape::blocks ? numbers() : blocks();
  std::fill_n(h, count * stride, 0.0);
  thread_local std::vector<double> one;  // of a term that is multiplied
  for (const JetAssembler::Term* const term : with_tangent_) {
    const JetAssembler::Term& t = *term;
    const double factor = factors.empty() ? 1 : factors[t.number];
    if (factor == 0) continue;
    const SampleBlock block = terms_->sample_block(geometries, t, first, size);
    if (factor == 1) {
      evaluate_term(t, block, kind, {h, stride, size, shape});
      continue;
    }
    one.assign(static_cast<std::size_t>(size * count), 0.0);
    evaluate_term(t, block, kind, {one.data(), size, size, shape});
    for (Index q = 0; q < count; ++q)
      for (Index s = 0; s < size; ++s)
        h[q * stride + s] += factor * one[static_cast<std::size_t>(q * size + s)];
  }
  if (shape != TangentShape::normal) return;
  const Geometry& now = geometries.mean != nullptr ? *geometries.mean : geometries.now;
  const ConstVectors n = now.block(first, size).n();
  std::copy_n(n.x, size, h + count * stride);
  std::copy_n(n.y, size, h + (count + 1) * stride);
  std::copy_n(n.z, size, h + (count + 2) * stride);
}

bool TangentAssembler::goes_on(Index a) const {
  if (blocks_.empty() || a >= terms_->gather().nodes()) return true;
  if (terms_->gather().run_end(a) == a + 1) return false;
  return std::ranges::all_of(terms_->gather().row(a).samples,
                             [&](std::int32_t s) { return terms_->samples().run_end(s) > s + 1; });
}

/// Which numbers of a sample make row a of Σ_m D_mᵀ A h_mn, l being the row's coefficients.
std::vector<TangentPlan::Left> TangentAssembler::left_of(const GatherTable::Coefficients& l,
                                                         int n) const {
  std::vector<TangentPlan::Left> left;
  const auto add = [&](std::size_t q, bool is_transposed, int m) {
    if (const double factor = l[static_cast<std::size_t>(m)]; factor != 0)
      left.push_back({static_cast<std::int16_t>(q), is_transposed, factor});
  };
  for (std::size_t q = 0; q < blocks_.size(); ++q) {
    if (blocks_[q].n == n) add(q, false, blocks_[q].m);
    if (blocks_[q].m == n && blocks_[q].n != n) add(q, true, blocks_[q].n);
  }
  return left;
}

void TangentAssembler::make_plan(const BlockMatrix& pattern, Index a, TangentPlan& plan,
                                 std::vector<std::int32_t>& samples) const {
  plan = {};
  const std::span<const std::int32_t> columns = pattern.columns(a);
  std::vector<std::vector<TangentPlan::Right>> right(columns.size());
  const GatherTable::Row row =
      a < terms_->gather().nodes() ? terms_->gather().row(a) : GatherTable::Row{};  // a scalar
  for (std::size_t e = 0; e < row.samples.size(); ++e) {
    const SampleSet::Stencil stencil = terms_->samples().stencil(row.samples[e]);
    const std::size_t parts = plan.parts.size();
    for (const int n : derivatives_) {
      const std::vector<TangentPlan::Left> left = left_of(row.l[e], n);
      if (left.empty()) continue;
      const auto part = static_cast<std::uint32_t>(plan.parts.size());
      bool is_used = false;
      for (std::size_t b = 0; b < stencil.nodes.size(); ++b) {
        const double d = stencil.d[b][static_cast<std::size_t>(n)];
        const auto column = std::ranges::lower_bound(columns, stencil.nodes[b]);
        if (d == 0 || column == columns.end() || *column != stencil.nodes[b])
          continue;  // nothing, or of the lower half
        right[static_cast<std::size_t>(column - columns.begin())].push_back({part, d});
        is_used = true;
      }
      if (!is_used) continue;
      plan.left.insert(plan.left.end(), left.begin(), left.end());
      plan.parts.push_back(
          {static_cast<std::uint32_t>(plan.samples), static_cast<std::uint32_t>(plan.left.size())});
    }
    if (plan.parts.size() == parts) continue;
    ++plan.samples;
    samples.push_back(row.samples[e]);
  }
  for (const std::vector<TangentPlan::Right>& of_block : right) {
    plan.right.insert(plan.right.end(), of_block.begin(), of_block.end());
    plan.right_end.push_back(static_cast<std::uint32_t>(plan.right.size()));
  }
}

}  // namespace deform
