#include "solve/tangent_assembler.h"

#include <algorithm>
#include <array>

#include "parallel/parallel.h"
#include "plugin/guard.h"

namespace deform {
namespace {

/// Rows that one task gathers.
constexpr Index kRows = 32;

using Matrix = Eigen::Matrix3d;

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
  h_.resize(static_cast<std::size_t>(terms_->samples().size()) * blocks_.size() * 9);
  slot_begin_.clear();
  slot_.clear();
  if (blocks_.empty()) return;
  const GatherTable& gather = terms_->gather();
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
}

void TangentAssembler::evaluate(const Geometries& geometries, Tangent kind,
                                const std::vector<double>& factors) {
  if (blocks_.empty()) return;
  const auto stride = static_cast<Index>(blocks_.size()) * 9;
  parallel_blocks(terms_->samples().size(), kBlock, [&](Index first, Index size) {
    std::fill_n(h_.data() + first * stride, size * stride, 0.0);
    const JetTangent tangent(h_.data() + first * stride, stride, places_, size);
    const SampleBlock block = terms_->sample_block(geometries, first, size);
    std::vector<double> one;  // of a term that is multiplied
    for (const JetAssembler::Term& t : terms_->terms()) {
      const double factor = factors.empty() ? 1 : factors[t.number];
      if (!t.traits.potential || factor == 0) continue;
      if (factor == 1) {
        guarded(t.origin, "computing its tangent", [&] { t.term->tangent(block, kind, tangent); });
        continue;
      }
      one.assign(static_cast<std::size_t>(size * stride), 0.0);
      const JetTangent alone(one.data(), stride, places_, size);
      guarded(t.origin, "computing its tangent", [&] { t.term->tangent(block, kind, alone); });
      for (std::size_t i = 0; i < one.size(); ++i)
        h_[static_cast<std::size_t>(first * stride) + i] += factor * one[i];
    }
  });
}

void TangentAssembler::add(BlockMatrix& k) const {
  if (blocks_.empty()) return;
  const GatherTable& gather = terms_->gather();
  const std::size_t stride = blocks_.size() * 9;
  parallel_blocks(gather.nodes(), kRows, [&](Index first, Index size) {
    std::array<Matrix, kDerivatives> left;
    for (Index a = first; a < first + size; ++a) {
      const GatherTable::Row row = gather.row(a);
      double* values = k.value.data() + 9 * Index{k.row_begin[static_cast<std::size_t>(a)]};
      for (std::size_t e = 0; e < row.samples.size(); ++e) {
        const GatherTable::Coefficients& l = row.l[e];
        // Row a of Σ_m D_mᵀ A h_mn for each derivative n …
        for (const int n : derivatives_) left[static_cast<std::size_t>(n)].setZero();
        const double* h = h_.data() + static_cast<std::size_t>(row.samples[e]) * stride;
        for (const auto& [m, n] : blocks_) {
          const Eigen::Map<const Matrix> block(h);
          const double l_m = l[static_cast<std::size_t>(m)], l_n = l[static_cast<std::size_t>(n)];
          if (l_m != 0) left[static_cast<std::size_t>(n)] += l_m * block;
          if (l_n != 0 && m != n) left[static_cast<std::size_t>(m)] += l_n * block.transpose();
          h += 9;
        }
        // … times the rows of D_n at the sample.
        const SampleSet::Stencil at = terms_->samples().stencil(row.samples[e]);
        const std::uint16_t* slots = slot_.data() + slot_begin_[gather.first_pair(a) + e];
        for (std::size_t b = 0; b < at.nodes.size(); ++b) {
          if (slots[b] == kNoSlot) continue;
          Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> block(values + 9 * slots[b]);
          for (const int n : derivatives_) {
            const double d = at.d[b][static_cast<std::size_t>(n)];
            if (d != 0) block += d * left[static_cast<std::size_t>(n)];
          }
        }
      }
    }
  });
}

}  // namespace deform
