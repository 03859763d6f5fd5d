/// Rows of a matrix by fours, so that vectors of the processor take four of them at once.
#pragma once

#include <cstdint>
#include <vector>

#include <deform/types.h>

namespace multigrid {

using deform::Index;

/// Rows of a quad; the first of each is a multiple of it.
inline constexpr Index kQuad = 4;

/// Up to a whole quad.
[[nodiscard]] constexpr std::size_t padded(Index nodes) {
  return static_cast<std::size_t>((nodes + kQuad - 1) / kQuad * kQuad);
}

/// Full rows, columns ascending.
struct Pattern {
  Index nodes = 0;
  std::vector<std::int32_t> begin{0};  ///< (N + 1)
  std::vector<std::int32_t> column;
};

/// Where a pattern's entries lie. Those of four rows lie side by side: entry e of all quads has the
/// places 4 e … 4 e + 3, one a row. Where the rows of a quad are alike, as they are within a grid,
/// an entry belongs to columns in sequence, too, from `column[e]` on; rows that lack one of these
/// have a 0 there. Elsewhere each row has its own columns, `gathered`.
class Quads {
 public:
  Quads() = default;
  explicit Quads(const Pattern& pattern);

  /// Places of all quads.
  [[nodiscard]] std::size_t places() const { return 4 * column_.size(); }
  /// Of entry p of the pattern, which is one of row a.
  [[nodiscard]] std::int32_t place(Index a, std::int32_t p) const {
    return static_cast<std::int32_t>(
        4 * (begin_[static_cast<std::size_t>(a / kQuad)] + position_[static_cast<std::size_t>(p)]) +
        a % kQuad);
  }

  /// Of the first entry of row a, if those of the others follow by fours, or −1.
  [[nodiscard]] std::int32_t first_place(const Pattern& pattern, Index a) const;

  /// For kernels: entries of quad q are begin[q] … begin[q + 1]; gather[q] is where `gathered`
  /// begins for it, four columns an entry, or −1.
  struct View {
    const std::int32_t *begin, *column;
    const std::int64_t* gather;
    const std::int32_t* gathered;
  };
  [[nodiscard]] View view() const {
    return {begin_.data(), column_.data(), gather_.data(), gathered_.data()};
  }

 private:
  [[nodiscard]] bool add_in_sequence(const Pattern& pattern, Index quad);
  void add_gathered(const Pattern& pattern, Index quad);

  std::vector<std::int32_t> begin_{0}, column_;
  std::vector<std::int64_t> gather_;
  std::vector<std::int32_t> gathered_;
  std::vector<std::uint16_t> position_;  // within the quad, of each entry of the pattern
  std::vector<std::int32_t> distances_;  // of one quad: columns less rows
};

}  // namespace multigrid
