/// How symmetric matrices lie: their upper half, by strips of rows.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <deform/types.h>

namespace multigrid {

using deform::Index;

/// Upper half of a symmetric pattern: the columns of row a are ≥ a, ascending, a first.
struct Pattern {
  Index nodes = 0;
  std::vector<std::int32_t> begin{0};  ///< (N + 1)
  std::vector<std::int32_t> column;
  [[nodiscard]] std::span<const std::int32_t> columns(Index a) const {
    const auto row = static_cast<std::size_t>(a);
    return std::span(column).subspan(static_cast<std::size_t>(begin[row]),
                                     static_cast<std::size_t>(begin[row + 1] - begin[row]));
  }
};

/// Rows that a strip is padded to: whole vectors of the processor.
inline constexpr Index kLanes = 4;
/// Numbers that there must be behind the last of a matrix: kernels load whole vectors.
inline constexpr std::size_t kOverrun = 32;

/// Where an entry's numbers are: number q at first + q · stride.
struct Place {
  std::int64_t first = 0;
  std::int32_t stride = 0;
};

/// Rows of a matrix that follow each other, as lines of a grid do, are a strip. Its entries are the
/// distances, column less row, that any of its rows has: each has its numbers for all rows of the
/// strip side by side, one number after another, 0 where a row lacks the entry. A strip ends where
/// a row does not touch the next, and where such zeros would become too many.
///
/// A product with the upper half alone reads half of what one with both triangles does, and each
/// number of an entry is used twice, for its row and for its column.
class Strips {
 public:
  struct Strip {
    Index row, size;       ///< rows row … row+size−1
    Index lanes;           ///< size, padded
    std::size_t distance;  ///< of its entries, in distances(); ascending, 0 first
    Index entries;         ///< how many
    std::int64_t begin;    ///< rows × entries before it, padded
  };
  /// Strips whose products are taken by one task. Columns end before `reach`.
  struct Chunk {
    std::size_t strip, strip_end;
    Index row, end, reach;
  };

  Strips() = default;
  explicit Strips(const Pattern& pattern);

  [[nodiscard]] const std::vector<Strip>& strips() const { return strips_; }
  [[nodiscard]] const std::vector<Chunk>& chunks() const { return chunks_; }
  [[nodiscard]] const Strip& strip_of(Index a) const {
    return strips_[static_cast<std::size_t>(strip_of_[static_cast<std::size_t>(a)])];
  }
  [[nodiscard]] std::span<const std::int32_t> distances(const Strip& strip) const {
    return std::span(distances_).subspan(strip.distance, static_cast<std::size_t>(strip.entries));
  }
  /// Which entry of a strip a distance is; the strip must have it.
  [[nodiscard]] Index entry(const Strip& strip, std::int32_t distance) const;
  /// Of the entry (a, a + distance) in a matrix of so many numbers an entry.
  [[nodiscard]] Place place(Index a, std::int32_t distance, Index numbers) const;
  /// Numbers of a matrix of so many an entry, and room to read beyond.
  [[nodiscard]] std::size_t size(Index numbers) const {
    return static_cast<std::size_t>(numbers * total_) + kOverrun;
  }
  /// What vectors of nodes need: some row's columns, padded, lie that far.
  [[nodiscard]] Index reach() const { return reach_; }

 private:
  [[nodiscard]] Index strip_end(const Pattern& pattern, Index first);
  void cut_chunks();

  std::vector<Strip> strips_;
  std::vector<std::int32_t> distances_;
  std::vector<std::int32_t> strip_of_;  // of each row
  std::vector<Chunk> chunks_;
  std::int64_t total_ = 0;
  Index reach_ = 0;
  std::vector<std::int32_t> of_strip_, more_;  // distances while a strip is made
};

}  // namespace multigrid
