/// Gathers the tangents of the terms on one sample set into blocks of a matrix.
#pragma once

#include <vector>

#include "deform/model/tangent.h"
#include "deform/solve/block_matrix.h"

#include "solve/jet_assembler.h"

namespace deform {

/// Terms with a potential; the others have no part in a tangent. Rows are gathered one by one in a
/// fixed order: the same bits at any number of threads.
class TangentAssembler {
 public:
  explicit TangentAssembler(const JetAssembler& terms);

  /// Calls visit(a, b), a ≤ b, for every block that the tangent may have.
  template <class Visit>
  void visit_pattern(const Visit& visit) const;
  /// Remembers where in a matrix of that pattern the blocks are.
  void bind(const BlockMatrix& pattern);

  /// Second derivatives of all terms' densities at every sample; `factors`: what each term of the
  /// scene is multiplied by, 1 where empty.
  void evaluate(const Geometries& geometries, Tangent kind,
                const std::vector<double>& factors = {});
  /// K += Σ D_mᵀ A h_mn D_n of the last evaluation.
  void add(BlockMatrix& k) const;

 private:
  struct Block {
    int m, n;  // derivatives
  };
  [[nodiscard]] bool depends(const std::array<double, kDerivatives>& d) const;
  [[nodiscard]] bool depends(const GatherTable::Coefficients& l) const;

  const JetAssembler* terms_;
  std::vector<int> derivatives_;  // that some density depends on
  std::vector<Block> blocks_;     // of a sample, upper triangle
  JetTangent::Places places_{};
  std::vector<double> h_;  // (m × blocks × 9)
  static constexpr std::uint16_t kNoSlot = 0xFFFF;
  std::vector<std::size_t> slot_begin_;
  std::vector<std::uint16_t> slot_;
};

template <class Visit>
void TangentAssembler::visit_pattern(const Visit& visit) const {
  if (blocks_.empty()) return;
  const GatherTable& gather = terms_->gather();
  for (Index a = 0; a < gather.nodes(); ++a) {
    const GatherTable::Row row = gather.row(a);
    for (std::size_t e = 0; e < row.samples.size(); ++e) {
      if (!depends(row.l[e])) continue;
      const SampleSet::Stencil at = terms_->samples().stencil(row.samples[e]);
      for (std::size_t k = 0; k < at.nodes.size(); ++k)
        if (at.nodes[k] >= a && depends(at.d[k])) visit(a, Index{at.nodes[k]});
    }
  }
}

}  // namespace deform
