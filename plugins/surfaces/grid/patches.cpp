#include "patches.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace grid {
namespace {

using deform::NodeValues;
using deform::ParameterRectangle;

using Interval = std::pair<double, double>;

/// A rectangle within the grid, in metres: its intervals of a1 and a2.
struct Patch {
  Interval of_1, of_2;
};

/// The parts of an interval that are on a line: cut off at open ends, around the seam of a joined
/// one.
std::vector<Interval> parts(double lower, double upper, double length, bool periodic) {
  if (!periodic) {
    lower = std::max(lower, 0.0), upper = std::min(upper, length);
    return lower < upper ? std::vector<Interval>{{lower, upper}} : std::vector<Interval>{};
  }
  if (upper - lower >= length) return {{0, length}};
  const double turns = length * std::floor(lower / length);
  lower = std::clamp(lower - turns, 0.0, length), upper -= turns;
  if (upper <= length) return {{lower, upper}};
  return {{lower, length}, {0, upper - length}};
}

/// ∫ of each node's hat function over an interval of a line of n nodes [m], added to `result`.
void add_hats(const Lattice& lattice, std::size_t direction, const Interval& interval,
              std::vector<double>& result) {
  const double h = lattice.h[direction];
  const double last = static_cast<double>(lattice.cells(direction) - 1);
  const auto first = static_cast<Index>(std::clamp(std::floor(interval.first / h), 0.0, last));
  for (Index cell = first; cell < lattice.cells(direction); ++cell) {
    const double begin = std::clamp(interval.first / h - static_cast<double>(cell), 0.0, 1.0),
                 end = std::clamp(interval.second / h - static_cast<double>(cell), 0.0, 1.0);
    if (end <= begin) break;
    const double of_next = 0.5 * (end - begin) * (end + begin);
    result[static_cast<std::size_t>(cell)] += h * (end - begin - of_next);
    result[static_cast<std::size_t>((cell + 1) % lattice.n[direction])] += h * of_next;
  }
}

/// Disjoint intervals in place of ones that overlap.
std::vector<Interval> united(std::vector<Interval> intervals) {
  std::ranges::sort(intervals);
  std::vector<Interval> result;
  for (const Interval& interval : intervals) {
    if (!result.empty() && interval.first <= result.back().second)
      result.back().second = std::max(result.back().second, interval.second);
    else
      result.push_back(interval);
  }
  return result;
}

std::vector<Patch> patches_of(const Lattice& lattice,
                              const std::vector<ParameterRectangle>& rectangles) {
  const auto cut = [&](const ParameterRectangle& r, std::size_t k) {
    const auto axis = static_cast<Index>(k);
    return parts(r.lower[axis], r.upper[axis], lattice.h[k] * static_cast<double>(lattice.cells(k)),
                 lattice.periodic[k]);
  };
  std::vector<Patch> patches;
  for (const ParameterRectangle& rectangle : rectangles)
    for (const Interval& of_1 : cut(rectangle, 0))
      for (const Interval& of_2 : cut(rectangle, 1)) patches.push_back({of_1, of_2});
  return patches;
}

}  // namespace

// Between neighbouring bounds of a1 the union is a product of two sets of intervals.
NodeValues areas_within(const Lattice& lattice, const std::vector<ParameterRectangle>& rectangles) {
  const std::vector<Patch> patches = patches_of(lattice, rectangles);
  std::vector<double> bounds;
  for (const Patch& patch : patches)
    bounds.insert(bounds.end(), {patch.of_1.first, patch.of_1.second});
  std::ranges::sort(bounds);
  bounds.erase(std::unique(bounds.begin(), bounds.end()), bounds.end());

  NodeValues result = NodeValues::Zero(lattice.nodes());
  std::vector<double> hats_1, hats_2;
  for (std::size_t b = 0; b + 1 < bounds.size(); ++b) {
    std::vector<Interval> across;
    for (const Patch& patch : patches)
      if (patch.of_1.first <= bounds[b] && patch.of_1.second >= bounds[b + 1])
        across.push_back(patch.of_2);
    if (across.empty()) continue;
    hats_1.assign(static_cast<std::size_t>(lattice.n[0]), 0.0);
    hats_2.assign(static_cast<std::size_t>(lattice.n[1]), 0.0);
    add_hats(lattice, 0, {bounds[b], bounds[b + 1]}, hats_1);
    for (const Interval& of_2 : united(std::move(across))) add_hats(lattice, 1, of_2, hats_2);
    for (Index j = 0; j < lattice.n[1]; ++j)
      for (Index i = 0; i < lattice.n[0]; ++i)
        result[lattice.node(i, j)] +=
            hats_1[static_cast<std::size_t>(i)] * hats_2[static_cast<std::size_t>(j)];
  }
  return result;
}

}  // namespace grid
