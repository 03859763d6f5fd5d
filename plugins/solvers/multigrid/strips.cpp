#include "strips.h"

#include <algorithm>

namespace multigrid {
namespace {

/// Entries of a strip, zeros for what rows lack included, relative to those that there are.
constexpr double kMostPadding = 1.5;
/// Rows of a strip: what a product reads and writes beside the matrix stays in the first cache.
constexpr Index kMostRows = 2048;
/// Rows of a chunk, and at least so many times what its last row reaches beyond.
constexpr Index kRowsOfChunk = 2048, kReaches = 6;

constexpr Index padded(Index rows) { return (rows + kLanes - 1) / kLanes * kLanes; }

bool touches_next(const Pattern& pattern, Index a) {
  return std::ranges::binary_search(pattern.columns(a), static_cast<std::int32_t>(a + 1));
}

}  // namespace

/// Takes rows as long as each touches the next and not too many zeros come with it; leaves their
/// distances in of_strip_.
Index Strips::strip_end(const Pattern& pattern, Index first) {
  of_strip_.clear();
  Index there = 0;  // entries
  for (Index a = first; a < pattern.nodes; ++a) {
    if (a > first && (a - first == kMostRows || !touches_next(pattern, a - 1))) return a;
    const std::span<const std::int32_t> columns = pattern.columns(a);
    more_ = of_strip_;
    for (const std::int32_t b : columns) {
      const std::int32_t distance = b - static_cast<std::int32_t>(a);
      const auto at = std::ranges::lower_bound(more_, distance);
      if (at == more_.end() || *at != distance) more_.insert(at, distance);
    }
    there += static_cast<Index>(columns.size());
    const auto all = static_cast<double>(more_.size()) * static_cast<double>(a + 1 - first);
    // The first rows of a line, which lack some, come before those that have all.
    const bool is_long = a - first >= kLanes;
    if (is_long && more_.size() > of_strip_.size() &&
        all > kMostPadding * static_cast<double>(there))
      return a;
    of_strip_.swap(more_);
  }
  return pattern.nodes;
}

Strips::Strips(const Pattern& pattern) {
  for (Index first = 0; first < pattern.nodes;) {
    const Index end = strip_end(pattern, first);
    const Index size = end - first;
    const auto entries = static_cast<Index>(of_strip_.size());
    strips_.push_back({first, size, padded(size), distances_.size(), entries, total_});
    distances_.insert(distances_.end(), of_strip_.begin(), of_strip_.end());
    total_ += padded(size) * entries;
    reach_ = std::max(reach_, first + padded(size) + of_strip_.back());
    strip_of_.resize(static_cast<std::size_t>(end), static_cast<std::int32_t>(strips_.size() - 1));
    first = end;
  }
  cut_chunks();
}

void Strips::cut_chunks() {
  for (std::size_t s = 0; s < strips_.size(); ++s) {
    const Strip& strip = strips_[s];
    const Index farthest = distances(strip).back();
    const bool is_full = !chunks_.empty() && chunks_.back().end - chunks_.back().row >=
                                                 std::max(kRowsOfChunk, kReaches * farthest);
    if (chunks_.empty() || is_full) chunks_.push_back({s, s, strip.row, strip.row, 0});
    Chunk& chunk = chunks_.back();
    chunk.strip_end = s + 1;
    chunk.end = strip.row + strip.size;
    chunk.reach = std::max(chunk.reach, strip.row + strip.lanes + farthest);
  }
}

Index Strips::entry(const Strip& strip, std::int32_t distance) const {
  const std::span<const std::int32_t> all = distances(strip);
  return std::ranges::lower_bound(all, distance) - all.begin();
}

Place Strips::place(Index a, std::int32_t distance, Index numbers) const {
  const Strip& strip = strip_of(a);
  return {numbers * (strip.begin + entry(strip, distance) * strip.lanes) + a - strip.row,
          static_cast<std::int32_t>(strip.lanes)};
}

}  // namespace multigrid
