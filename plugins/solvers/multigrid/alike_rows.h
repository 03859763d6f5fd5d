/// Matrices by rows of which many are alike, as those of interpolations on grids are.
#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <utility>
#include <vector>

#include <deform/types.h>

namespace multigrid {

using deform::Index;

/// Rows whose columns lie equally far from the first, with the same weights, share these: what is
/// left of a row is a few bytes.
class AlikeRows {
 public:
  struct Entry {
    std::int32_t column = 0;
    float weight = 0;
  };

  void add(std::span<const Entry> row);
  [[nodiscard]] Index rows() const { return static_cast<Index>(first_.size()); }
  [[nodiscard]] std::size_t size(Index row) const {
    const Kind kind = kind_[static_cast<std::size_t>(row)];
    return kind.end - kind.begin;
  }
  /// Column of a row's first entry.
  [[nodiscard]] std::int32_t first(Index row) const {
    return first_[static_cast<std::size_t>(row)];
  }
  /// Columns less the first, and weights.
  [[nodiscard]] std::span<const Entry> shared(Index row) const {
    return std::span(shared_).subspan(kind_[static_cast<std::size_t>(row)].begin, size(row));
  }
  [[nodiscard]] Entry entry(Index row, std::size_t k) const {
    const Entry& e = shared(row)[k];
    return {first(row) + e.column, e.weight};
  }
  /// Whether the weights are those of another row and the columns by as much further as the first.
  [[nodiscard]] bool are_alike(Index row, Index other) const {
    return kind_[static_cast<std::size_t>(row)] == kind_[static_cast<std::size_t>(other)];
  }

 private:
  struct Kind {
    std::uint32_t begin = 0, end = 0;  // in shared_
    bool operator==(const Kind&) const = default;
  };
  std::vector<std::int32_t> first_;  // column of each row
  std::vector<Kind> kind_;
  std::vector<Entry> shared_;  // columns less the first
  std::map<std::vector<std::pair<std::int32_t, float>>, Kind> kinds_;
};

}  // namespace multigrid
