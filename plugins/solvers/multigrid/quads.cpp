#include "quads.h"

#include <algorithm>

namespace multigrid {
namespace {

/// Rows whose columns are in sequence may have so many entries together, relative to the longest.
constexpr double kMostPadding = 1.5;

}  // namespace

Quads::Quads(const Pattern& pattern) {
  position_.resize(pattern.column.size());
  for (Index quad = 0; quad < static_cast<Index>(padded(pattern.nodes)) / kQuad; ++quad)
    if (!add_in_sequence(pattern, quad)) add_gathered(pattern, quad);
}

std::int32_t Quads::first_place(const Pattern& pattern, Index a) const {
  const std::int32_t begin = pattern.begin[static_cast<std::size_t>(a)],
                     end = pattern.begin[static_cast<std::size_t>(a) + 1];
  for (std::int32_t p = begin; p < end; ++p)
    if (place(a, p) != place(a, begin) + 4 * (p - begin)) return -1;
  return place(a, begin);
}

/// The distances that any of the four rows has; false where these are too many, or lead beyond the
/// nodes.
bool Quads::add_in_sequence(const Pattern& pattern, Index quad) {
  const Index first = kQuad * quad, end = std::min(first + kQuad, pattern.nodes);
  distances_.clear();
  std::int32_t longest = 0;
  const auto visit = [&](const auto& take) {
    for (Index a = first; a < end; ++a)
      for (auto p = pattern.begin[static_cast<std::size_t>(a)];
           p < pattern.begin[static_cast<std::size_t>(a) + 1]; ++p)
        take(static_cast<std::size_t>(p),
             pattern.column[static_cast<std::size_t>(p)] - static_cast<std::int32_t>(a));
  };
  visit([&](std::size_t /*p*/, std::int32_t distance) { distances_.push_back(distance); });
  for (auto a = static_cast<std::size_t>(first); a < static_cast<std::size_t>(end); ++a)
    longest = std::max(longest, pattern.begin[a + 1] - pattern.begin[a]);
  std::ranges::sort(distances_);
  distances_.erase(std::unique(distances_.begin(), distances_.end()), distances_.end());
  if (static_cast<double>(distances_.size()) > kMostPadding * longest) return false;
  if (first + distances_.front() < 0 ||
      first + distances_.back() + kQuad > static_cast<Index>(padded(pattern.nodes)))
    return false;
  visit([&](std::size_t p, std::int32_t distance) {
    position_[p] = static_cast<std::uint16_t>(std::ranges::lower_bound(distances_, distance) -
                                              distances_.begin());
  });
  for (const std::int32_t distance : distances_)
    column_.push_back(static_cast<std::int32_t>(first) + distance);
  begin_.push_back(static_cast<std::int32_t>(column_.size()));
  gather_.push_back(-1);
  return true;
}

/// The entries of each row one after another; shorter rows go on with node 0, times 0.
void Quads::add_gathered(const Pattern& pattern, Index quad) {
  const Index first = kQuad * quad, end = std::min(first + kQuad, pattern.nodes);
  const auto begin = static_cast<std::size_t>(gathered_.size());
  gather_.push_back(static_cast<std::int64_t>(begin));
  for (Index a = first; a < end; ++a) {
    const auto row = static_cast<std::size_t>(a);
    const auto size = static_cast<std::size_t>(pattern.begin[row + 1] - pattern.begin[row]);
    if (gathered_.size() < begin + 4 * size) gathered_.resize(begin + 4 * size, 0);
    for (std::size_t k = 0; k < size; ++k) {
      const std::size_t p = static_cast<std::size_t>(pattern.begin[row]) + k;
      position_[p] = static_cast<std::uint16_t>(k);
      gathered_[begin + 4 * k + static_cast<std::size_t>(a - first)] = pattern.column[p];
    }
  }
  column_.resize(column_.size() + (gathered_.size() - begin) / 4, 0);
  begin_.push_back(static_cast<std::int32_t>(column_.size()));
}

}  // namespace multigrid
