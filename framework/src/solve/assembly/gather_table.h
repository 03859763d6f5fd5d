/// The transposed operators of a sample set, node by node: who gives what to a node's force and
/// matrix row.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "deform/model/energy_term.h"
#include "deform/surface/sample_set.h"
#include "deform/types.h"

namespace deform {

/// For each node a, the samples s that act on it, ascending, with the coefficients L_m[a, s] of
/// each channel m: D_m[s, a] A_s for D_mᵀ A, and −A_a D_i^-[a, s] for the strong form's channels.
/// Forces on nodes are then f_a = −Σ_s Σ_m L_m[a, s] σ_m[s].
class GatherTable {
 public:
  using Coefficients = std::array<double, kChannels>;
  struct Row {
    std::span<const std::int32_t> samples;
    const Coefficients* l;  ///< one a sample
  };

  GatherTable() = default;
  explicit GatherTable(const SampleSet& samples);

  [[nodiscard]] Index nodes() const { return static_cast<Index>(begin_.size()) - 1; }
  [[nodiscard]] Row row(Index a) const {
    const auto i = static_cast<std::size_t>(a);
    const auto begin = static_cast<std::size_t>(begin_[i]),
               end = static_cast<std::size_t>(begin_[i + 1]);
    return {{samples_.data() + begin, end - begin}, pool_.data() + pool_begin_[i]};
  }
  /// The end of the run of rows that a row is in: rows with the same coefficients, whose samples
  /// are counted on by one from each to the next.
  [[nodiscard]] Index run_end(Index a) const { return run_end_[static_cast<std::size_t>(a)]; }
  /// Number of the row's first (node, sample) pair among all.
  [[nodiscard]] std::size_t first_pair(Index a) const {
    return static_cast<std::size_t>(begin_[static_cast<std::size_t>(a)]);
  }
  [[nodiscard]] std::size_t pairs() const { return samples_.size(); }

 private:
  [[nodiscard]] bool goes_on(Index a) const;
  void find_runs();

  std::vector<Index> begin_{0};
  std::vector<std::int32_t> samples_;
  std::vector<std::size_t> pool_begin_;  // rows with the same coefficients share them
  std::vector<Coefficients> pool_;
  std::vector<std::int32_t> run_end_;
};

}  // namespace deform
