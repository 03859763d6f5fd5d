#include "solve/matrix/growing_pattern.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "solve/assembly/block_pattern.h"
#include "solve/assembly/tangent_rows.h"

namespace deform {
namespace {

/// Blocks that nobody has asked for in so many calls go when the pattern changes.
constexpr long kKept = 20;

}  // namespace

/// Notes which blocks are asked for; returns whether the matrix lacks one.
bool GrowingPattern::ask_for(std::span<const BlockEntry> entries) {
  ++calls_;
  bool lacks = false;
  for (const BlockEntry& e : entries) {
    const auto [a, b] = std::minmax(e.a, e.b);
    if (a < 0 || b >= matrix.nodes)
      throw std::out_of_range("a block of a matrix between nodes that it does not have");
    if (std::ranges::binary_search(base_->columns(a), static_cast<std::int32_t>(b))) continue;
    const auto at =
        std::ranges::lower_bound(extras_, std::pair<Index, Index>(a, b), {}, &Extra::place);
    if (at != extras_.end() && at->place() == std::pair<Index, Index>(a, b)) {
      at->asked = calls_;
    } else {
      extras_.insert(at, {a, b, calls_});
      lacks = true;
    }
  }
  return lacks;
}

bool GrowingPattern::grow(std::span<const BlockEntry> entries) {
  if (!ask_for(entries)) return false;
  std::erase_if(extras_, [&](const Extra& e) { return calls_ - e.asked > kKept; });
  rebuild();
  return true;
}

void GrowingPattern::rebuild() {
  BlockPatternBuilder builder(matrix.nodes);
  for (Index a = 0; a < base_->nodes; ++a)
    for (const std::int32_t b : base_->columns(a)) builder.add(a, b);
  for (const Extra& e : extras_) builder.add(e.a, e.b);
  BlockMatrix grown = builder.build();
  grown.value.assign(9 * grown.column.size(), 0.0);
  for (Index a = 0; a < matrix.nodes && !matrix.value.empty(); ++a)
    for (const std::int32_t b : matrix.columns(a))
      if (std::ranges::binary_search(grown.columns(a), b)) grown.block(a, b) = matrix.block(a, b);
  place_.clear();
  for (Index a = 0; a < base_->nodes; ++a) {
    const auto columns = grown.columns(a);
    for (const std::int32_t b : base_->columns(a))
      place_.push_back(
          static_cast<std::int32_t>(grown.row_begin[static_cast<std::size_t>(a)] +
                                    (std::ranges::lower_bound(columns, b) - columns.begin())));
  }
  matrix = std::move(grown);
  is_grown_ = true;
}

void GrowingPattern::add(const BlockEntry& entry) {
  if (entry.a <= entry.b)
    matrix.block(entry.a, entry.b) += entry.block;
  else
    matrix.block(entry.b, entry.a) += entry.block.transpose();
}

bool GrowingPattern::store(const BlockRows& rows) {
  if (!is_grown_) {
    const std::int32_t* const begin = matrix.row_begin.data() + rows.row;
    const Index numbers = 9 * Index{begin[1] - begin[0]};
    std::array<double*, kRowLanes> to{};
    for (Index q = 0; q < rows.size; ++q)
      to[static_cast<std::size_t>(q)] = matrix.value.data() + 9 * Index{begin[q]};
    return rows.lanes == 1 ? store_row(rows.value, numbers, to[0], false)
                           : store_rows(rows.value, rows.size, numbers, to.data(), false);
  }
  bool is_finite = true;
  for (Index q = 0; q < rows.size; ++q) {
    const auto row = static_cast<std::size_t>(rows.row + q);
    double* const all = matrix.value.data();
    std::fill(all + 9 * Index{matrix.row_begin[row]}, all + 9 * Index{matrix.row_begin[row + 1]},
              0.0);
    const double* value = rows.value + q;
    for (std::int32_t p = base_->row_begin[row]; p < base_->row_begin[row + 1]; ++p)
      for (int i = 0; i < 9; ++i, value += rows.lanes) {
        all[9 * Index{place_[static_cast<std::size_t>(p)]} + i] = *value;
        is_finite = is_finite && std::isfinite(*value);
      }
  }
  return is_finite;
}

}  // namespace deform
