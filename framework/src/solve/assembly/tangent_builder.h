/// Makes the matrix of a tangent from the terms on all sample sets.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "solve/assembly/model_terms.h"
#include "solve/assembly/tangent_assembler.h"
#include "solve/assembly/tangent_schedule.h"

namespace deform {

/// Each row is made in a fixed order: the same bits at any number of threads.
class TangentBuilder {
 public:
  /// `terms` must live as long.
  explicit TangentBuilder(ModelTerms& terms) : terms_(&terms) {}
  TangentBuilder(const TangentBuilder&) = delete;
  TangentBuilder& operator=(const TangentBuilder&) = delete;

  /// The blocks that tangents of terms and force fields may have, without values. Made when first
  /// asked for, as are the plans of rows: both take a while, and not every integrator needs them.
  [[nodiscard]] const BlockMatrix& pattern();

  /// What of: geometries, one a set; factors, what each term of the scene is multiplied by, 1 where
  /// empty.
  struct Wanted {
    std::span<const Geometries> geometries;
    Tangent kind;
    const std::vector<double>& factors;
  };
  /// Takes some rows; returns whether what became of them is finite. Called from several threads at
  /// once, for different rows.
  using TakeRows = std::function<bool(const BlockRows&)>;
  /// Makes each row of K = Σ D_mᵀ A h_mn D_n, the sum being over sets. Returns whether all rows are
  /// finite.
  bool make_rows(const Wanted& wanted, const TakeRows& take);
  /// The same to a matrix of the pattern, blocks that none adds to becoming 0; or K += Σ with
  /// `adds`.
  bool assemble(const Wanted& wanted, BlockMatrix& k, bool adds = false);

 private:
  void prepare();
  [[nodiscard]] bool make_segment(const TangentSchedule::Segment& segment, const Wanted& wanted,
                                  const TakeRows& take) const;
  [[nodiscard]] bool make_group(const TangentSchedule::Group& group, const TakeRows& take) const;

  ModelTerms* terms_;
  std::vector<TangentAssembler> sets_;
  BlockMatrix pattern_;
  std::optional<TangentSchedule> schedule_;
  std::vector<TangentShape> shapes_;  // of each set, what is made now
};

}  // namespace deform
