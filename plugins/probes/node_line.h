/// Lines of nodes: a hem, a side.
#pragma once

#include <algorithm>
#include <vector>

#include <deform/types.h>

namespace deform {

/// The line's nodes in the order of the parameter that varies along it.
inline std::vector<Index> in_order(std::vector<Index> line, const Eigen::MatrixX2d& parameters) {
  const Eigen::MatrixX2d along = parameters(line, Eigen::all);
  const Vec2 extent = along.colwise().maxCoeff() - along.colwise().minCoeff();
  const int axis = extent[0] >= extent[1] ? 0 : 1;
  std::ranges::sort(line,
                    [&](Index a, Index b) { return parameters(a, axis) < parameters(b, axis); });
  return line;
}

/// Length of the polygon through them at positions r (N × 3) [m].
inline double length_of(const std::vector<Index>& line, const NodeVectors& r) {
  double length = 0;
  for (std::size_t k = 1; k < line.size(); ++k)
    length += (r.row(line[k]) - r.row(line[k - 1])).norm();
  return length;
}

}  // namespace deform
