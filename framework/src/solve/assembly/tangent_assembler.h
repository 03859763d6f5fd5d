/// Tangents of the terms on one sample set: their second derivatives at samples, and how rows of
/// the matrix are made of them.
#pragma once

#include <vector>

#include "deform/model/tangent.h"
#include "deform/solve/block_matrix.h"

#include "solve/assembly/jet_assembler.h"
#include "solve/assembly/tangent_rows.h"

namespace deform {

/// Terms with a potential; those without one have a positive semidefinite approximation of their
/// stress's derivative, or no part in a tangent.
class TangentAssembler {
 public:
  explicit TangentAssembler(const JetAssembler& terms);
  /// Stresses of the strong form are derivatives of fields, which a sample alone does not know:
  /// such terms have a tangent where it has a special shape.
  [[nodiscard]] static bool has_tangent(const JetAssembler::Term& term);

  /// Calls visit(a, b), a ≤ b, for every block that the tangent may have.
  template <class Visit>
  void visit_pattern(const Visit& visit) const;

  /// Pairs of derivatives, m ≤ n, that some density depends on.
  [[nodiscard]] Index blocks() const { return static_cast<Index>(blocks_.size()); }
  /// How many numbers a sample has, at most: 9 for each of these.
  [[nodiscard]] Index numbers() const { return blocks() * 9; }
  /// What the terms' tangents of a kind are, all of them.
  [[nodiscard]] TangentShape shape(Tangent kind) const;
  /// Second derivatives of all terms' densities at samples first … first+size−1, number q of the
  /// k-th of them at h[q·stride + k], all numbers() · stride of which are the caller's; `factors`:
  /// what each term of the scene is multiplied by, 1 where empty. `shape`: as SampleNumbers has
  /// them then.
  void evaluate(const Geometries& geometries, Tangent kind, const std::vector<double>& factors,
                Index first, Index size, TangentShape shape, double* h, Index stride) const;

  /// Whether rows a and a + 1 of the matrix are made alike, of samples counted on by one.
  [[nodiscard]] bool goes_on(Index a) const;
  /// How row a of a matrix is made, of the samples that are appended to `samples`.
  void make_plan(const BlockMatrix& pattern, Index a, TangentPlan& plan,
                 std::vector<std::int32_t>& samples) const;

 private:
  /// What a term adds to, at some samples.
  struct Numbers {
    double* h;
    Index stride, size;
    TangentShape shape;
  };
  void evaluate_term(const JetAssembler::Term& term, const SampleBlock& block, Tangent kind,
                     const Numbers& to) const;
  [[nodiscard]] std::vector<TangentPlan::Left> left_of(const GatherTable::Coefficients& l,
                                                       int n) const;
  struct Block {
    int m, n;  // derivatives
  };
  [[nodiscard]] static Tangent kind_of(const JetAssembler::Term& term, Tangent kind);
  [[nodiscard]] bool depends(const std::array<double, kDerivatives>& d) const;
  [[nodiscard]] bool depends(const GatherTable::Coefficients& l) const;

  const JetAssembler* terms_;
  std::vector<const JetAssembler::Term*> with_tangent_;
  std::vector<int> derivatives_;  // that some density depends on
  std::vector<Block> blocks_;     // of a sample, upper triangle
  JetTangent::Places places_{};
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
