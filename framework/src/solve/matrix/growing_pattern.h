/// A matrix of blocks whose pattern may gain blocks.
#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "deform/solve/block_matrix.h"
#include "deform/solve/newton_matrix.h"

namespace deform {

/// The pattern of a model's tangent, and blocks that come and go (contacts between any nodes).
/// Blocks stay as long as the pattern need not change for others, and then those that were asked
/// for lately: what comes and goes from one iteration to the next changes nothing.
class GrowingPattern {
 public:
  /// `base` must live as long.
  explicit GrowingPattern(const BlockMatrix& base) : matrix(base), base_(&base) {}
  GrowingPattern(const GrowingPattern&) = delete;
  GrowingPattern& operator=(const GrowingPattern&) = delete;

  /// Whether it has more blocks than its base, whose rows are not the matrix' then.
  [[nodiscard]] bool is_grown() const { return is_grown_; }
  /// Sees to it that the matrix has a block for each entry; values stay. Returns whether its
  /// pattern has changed. Throws std::out_of_range where a node is none.
  bool grow(std::span<const BlockEntry> entries);
  /// Adds an entry's block, which the matrix has.
  void add(const BlockEntry& entry);
  /// Writes rows of the base's pattern; blocks that these lack become 0. Returns whether the rows
  /// are finite.
  [[nodiscard]] bool store(const BlockRows& rows);

  BlockMatrix matrix;

 private:
  /// A block that the base lacks, a < b, and the last call of `grow` that asked for it.
  struct Extra {
    Index a, b;
    long asked;
    [[nodiscard]] std::pair<Index, Index> place() const { return {a, b}; }
  };
  [[nodiscard]] bool ask_for(std::span<const BlockEntry> entries);
  void rebuild();

  const BlockMatrix* base_;
  bool is_grown_ = false;
  std::vector<Extra> extras_;  // by place
  long calls_ = 0;             // of `grow`
  std::vector<std::int32_t>
      place_;  // of each of the base's blocks in the matrix, where it is grown
};

}  // namespace deform
