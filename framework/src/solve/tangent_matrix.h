/// Makes the matrix of a tangent from the terms on all sample sets.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "solve/tangent_assembler.h"
#include "solve/tangent_schedule.h"

namespace deform {

/// Each row is made in a fixed order: the same bits at any number of threads.
class TangentMatrix {
 public:
  void add(const JetAssembler& terms) { sets_.emplace_back(terms); }
  [[nodiscard]] const std::vector<TangentAssembler>& sets() const { return sets_; }
  /// Once all sets are there: finds out how rows of matrices of that pattern are made.
  void bind(const BlockMatrix& pattern) { schedule_.emplace(sets_, pattern); }

  /// K = Σ D_mᵀ A h_mn D_n over sets, blocks of the pattern that none adds to becoming 0; or K += Σ
  /// with `adds`. `geometries`: one a set; `factors`: what each term of the scene is multiplied by,
  /// 1 where empty. Returns whether all that was written is finite.
  bool assemble(std::span<const Geometries> geometries, Tangent kind,
                const std::vector<double>& factors, BlockMatrix& k, bool adds = false) const;

 private:
  [[nodiscard]] bool assemble_segment(const TangentSchedule::Segment& segment,
                                      std::span<const Geometries> geometries, Tangent kind,
                                      const std::vector<double>& factors, BlockMatrix& k,
                                      bool adds) const;
  [[nodiscard]] bool gather(const TangentSchedule::Group& group, const double* h, double* rows,
                            BlockMatrix& k, bool adds) const;

  std::vector<TangentAssembler> sets_;
  std::optional<TangentSchedule> schedule_;
};

}  // namespace deform
