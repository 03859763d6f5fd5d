#include "coarsening.h"

#include <algorithm>
#include <utility>

namespace grid {
namespace {

/// Lines of so few nodes stay as they are.
constexpr std::size_t kFewest = 5;
/// Spacings within this factor are about the same.
constexpr double kAlike = 1.5;

/// The nodes of one direction.
struct Places {
  std::vector<double> at;  ///< ascending [m]
  double period = 0;       ///< [m]; 0 where the sides are open

  [[nodiscard]] bool may_be_coarser() const { return at.size() > kFewest; }
  [[nodiscard]] double spacing() const {
    return (at.back() - at.front()) / static_cast<double>(at.size() - 1);
  }
};

/// A row of the prolongation along one direction: coarse places and weights.
using Shares = std::vector<std::pair<Index, double>>;

Places places(const Lattice& lattice, std::size_t direction) {
  Places p;
  for (Index i = 0; i < lattice.n[direction]; ++i)
    p.at.push_back(static_cast<double>(i) * lattice.h[direction]);
  if (lattice.periodic[direction])
    p.period = static_cast<double>(lattice.n[direction]) * lattice.h[direction];
  return p;
}

std::vector<Shares> unchanged(const Places& fine) {
  std::vector<Shares> rows;
  for (std::size_t i = 0; i < fine.at.size(); ++i) rows.push_back({{static_cast<Index>(i), 1.0}});
  return rows;
}

/// Replaces places by every second one, and the last of an open line.
std::vector<Shares> make_coarser(Places& line) {
  const std::vector<double> fine = std::exchange(line.at, {});
  const std::size_t n = fine.size();
  const auto is_kept = [&](std::size_t i) {
    return i % 2 == 0 || (line.period == 0 && i == n - 1);
  };
  std::vector<Shares> rows;
  for (std::size_t i = 0; i < n; ++i) {
    const auto next = static_cast<Index>(line.at.size());  // coarse place behind those so far
    if (is_kept(i)) {
      rows.push_back({{next, 1.0}});
      line.at.push_back(fine[i]);
      continue;
    }
    const bool wraps = i + 1 == n;  // the last of a periodic line lies before the first
    const double before = fine[i - 1], after = wraps ? fine[0] + line.period : fine[i + 1];
    const double share = (fine[i] - before) / (after - before);
    rows.push_back({{next - 1, 1 - share}, {wraps ? 0 : next, share}});
  }
  return rows;
}

/// Rows of places that are kept get a part of their neighbours, by which the linear rows become
/// those of cubic B-splines: 1/8, 6/8, 1/8. Linear functions are kept where distances differ, and
/// the ends of open lines stay what they are.
void make_smooth(std::vector<Shares>& rows, const Places& coarse) {
  constexpr double kOfNeighbours = 0.25;
  const auto n = static_cast<Index>(coarse.at.size());
  const auto distance = [&](Index from, Index to) {  // upwards
    const double d =
        coarse.at[static_cast<std::size_t>(to)] - coarse.at[static_cast<std::size_t>(from)];
    return d > 0 ? d : d + coarse.period;
  };
  for (Shares& row : rows) {
    if (row.size() > 1) continue;
    const Index i = row.front().first;
    if (coarse.period == 0 && (i == 0 || i == n - 1)) continue;
    const Index before = (i + n - 1) % n, after = (i + 1) % n;
    const double below = distance(before, i), above = distance(i, after);
    const double part = kOfNeighbours / (below + above);
    row = {{before, part * above}, {i, 1 - kOfNeighbours}, {after, part * below}};
  }
}

/// All pairs of weights, coarse nodes ascending.
deform::Prolongation product(const std::vector<Shares>& along_1, const std::vector<Shares>& along_2,
                             Index n_1, Index n_2) {
  deform::Prolongation p;
  p.coarse = n_1 * n_2;
  for (const Shares& row_2 : along_2)
    for (const Shares& row_1 : along_1) {
      Shares row;
      for (const auto& [j, w_2] : row_2)
        for (const auto& [i, w_1] : row_1) row.emplace_back(i + n_1 * j, w_1 * w_2);
      std::ranges::sort(row);
      for (const auto& [node, weight] : row) {
        p.node.push_back(static_cast<std::int32_t>(node));
        p.weight.push_back(weight);
      }
      p.begin.push_back(static_cast<std::int32_t>(p.node.size()));
    }
  return p;
}

}  // namespace

std::vector<deform::Prolongation> coarsening(const Lattice& lattice, Interpolation interpolation) {
  std::vector<deform::Prolongation> all;
  std::array<Places, 2> line{places(lattice, 0), places(lattice, 1)};
  while (line[0].may_be_coarser() || line[1].may_be_coarser()) {
    double closest = deform::kInfinity;
    for (const Places& l : line)
      if (l.may_be_coarser()) closest = std::min(closest, l.spacing());
    std::array<std::vector<Shares>, 2> rows;
    for (const std::size_t k : {std::size_t{0}, std::size_t{1}}) {
      const bool is_close = line[k].may_be_coarser() && line[k].spacing() <= kAlike * closest;
      rows[k] = is_close ? make_coarser(line[k]) : unchanged(line[k]);
      if (is_close && interpolation == Interpolation::smooth) make_smooth(rows[k], line[k]);
    }
    all.push_back(product(rows[0], rows[1], static_cast<Index>(line[0].at.size()),
                          static_cast<Index>(line[1].at.size())));
  }
  return all;
}

}  // namespace grid
