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

  /// Rows that are gathered at once.
  static constexpr Index kLanes = 32;
  /// The end of the run that a row is in: rows that are alike but for being counted on.
  [[nodiscard]] Index run_end(Index a) const { return run_end_[static_cast<std::size_t>(a)]; }
  /// What goes into the rows of a run, found once for all of them.
  class Plan;
  /// Adds rows a … a+size−1 of Σ D_mᵀ A h_mn D_n of the last evaluation, of the plan's run, to
  /// `rows`: number q of the matrix row's blocks, of row a + k, is at q·width + k; width: 1, or
  /// kLanes.
  void accumulate(const Plan& plan, Index a, Index width, double* rows) const;
  void make_plan(Index a, Plan& plan) const;

 private:
  struct Block {
    int m, n;  // derivatives
  };
  [[nodiscard]] bool depends(const std::array<double, kDerivatives>& d) const;
  [[nodiscard]] bool depends(const GatherTable::Coefficients& l) const;
  [[nodiscard]] bool goes_on(Index a) const;

  const JetAssembler* terms_;
  std::vector<int> derivatives_;  // that some density depends on
  std::vector<Block> blocks_;     // of a sample, upper triangle
  JetTangent::Places places_{};
  std::vector<double> h_;  // (blocks × 9 × m), and room for kLanes beyond
  static constexpr std::uint16_t kNoSlot = 0xFFFF;
  std::vector<std::size_t> slot_begin_;
  std::vector<std::uint16_t> slot_;
  std::vector<std::int32_t> run_end_;
};

/// Row a of Σ_m D_mᵀ A h_mn for each derivative n, at each sample of the row; times the rows of
/// D_n.
class TangentAssembler::Plan {
 public:
  struct Left {
    std::int16_t n, block;         // adds l times that block, or its transpose
    bool is_transposed, is_first;  // first: of that n, at the sample
    double l;
  };
  struct Right {
    std::int16_t n, slot;
    double d;
  };
  struct Sample {
    std::int32_t sample;  // of the run's first row
    std::uint32_t left, left_end, right, right_end;
  };

  Index row = 0;  // the run's first
  std::vector<Left> left;
  std::vector<Right> right;
  std::vector<Sample> samples;
};

/// K = Σ over sets, blocks of the pattern that none adds to becoming 0; or K += Σ.
void gather_tangents(const std::vector<TangentAssembler>& sets, BlockMatrix& k, bool adds = false);

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
