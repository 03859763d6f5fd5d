#include "report/shown_mesh.h"

#include <algorithm>
#include <numeric>

namespace deform {
namespace {

/// Of the extent: parameters that rounding made different.
constexpr double kSlack = 1e-9;
/// Cells along a side that stay, where it has as many.
constexpr std::size_t kLeastCells = 8;

/// The different ones of the numbers, ascending, and of each number which of them it is.
void rank(const Eigen::VectorXd& numbers, std::vector<double>& values,
          std::vector<std::size_t>& ranks) {
  std::vector<Index> order(static_cast<std::size_t>(numbers.size()));
  std::iota(order.begin(), order.end(), Index{0});
  std::ranges::sort(order, {}, [&numbers](Index i) { return numbers[i]; });
  const double slack = kSlack * (numbers.maxCoeff() - numbers.minCoeff());
  ranks.resize(order.size());
  for (const Index i : order) {
    if (values.empty() || numbers[i] - values.back() > slack) values.push_back(numbers[i]);
    ranks[static_cast<std::size_t>(i)] = values.size() - 1;
  }
}

/// The faces' corners' ranks along one axis: their step, from the lower to the higher.
struct Span {
  std::size_t low, high;
  [[nodiscard]] bool joins(std::size_t count) const {
    return count > 2 && low == 0 && high == count - 1;
  }
  [[nodiscard]] bool is_cell(std::size_t count) const { return high == low + 1 || joins(count); }
};

}  // namespace

std::optional<ParameterLattice> ParameterLattice::of(const TrajectoryMesh& mesh) {
  ParameterLattice lattice(mesh);
  if (mesh.areas.size() == 0 || !lattice.place_nodes() || !lattice.has_all_faces())
    return std::nullopt;
  return lattice;
}

bool ParameterLattice::place_nodes() {
  for (std::size_t axis = 0; axis < 2; ++axis)
    rank(mesh_->parameters.col(static_cast<Index>(axis)), values_[axis], rank_[axis]);
  const std::size_t count = rank_[0].size();
  if (values_[0].size() * values_[1].size() != count) return false;
  nodes_.assign(count, -1);
  for (std::size_t k = 0; k < count; ++k) {
    std::int32_t& place = node(rank_[0][k], rank_[1][k]);
    if (place >= 0) return false;
    place = static_cast<std::int32_t>(k);
  }
  return true;
}

/// Every cell between neighbouring values has to be a face: what has holes must not lose them.
bool ParameterLattice::has_all_faces() {
  const Faces& faces = mesh_->faces;
  const auto span = [&](std::size_t axis, const std::int32_t* corners) {
    const auto rank_of = [&](std::int32_t k) { return rank_[axis][static_cast<std::size_t>(k)]; };
    const auto [low, high] = std::ranges::minmax(std::array{
        rank_of(corners[0]), rank_of(corners[1]), rank_of(corners[2]), rank_of(corners[3])});
    return Span{low, high};
  };
  for (std::size_t f = 0; f + 1 < faces.begin.size(); ++f) {
    if (faces.begin[f + 1] - faces.begin[f] != 4) return false;
    const std::int32_t* corners = faces.nodes.data() + faces.begin[f];
    bool inside = true;
    for (std::size_t axis = 0; axis < 2; ++axis) {
      const Span s = span(axis, corners);
      if (!s.is_cell(values_[axis].size())) return false;
      if (s.joins(values_[axis].size())) joined_[axis] = true, inside = false;
    }
    if (!inside) continue;
    const auto at = [&](std::size_t k) -> Vec2 { return mesh_->parameters.row(corners[k]); };
    const Vec2 u = at(2) - at(0), v = at(3) - at(1);
    turned_ = u.x() * v.y() - u.y() * v.x() < 0;
  }
  const auto cells = [this](std::size_t axis) {
    return values_[axis].size() - (joined_[axis] ? 0 : 1);
  };
  return static_cast<std::size_t>(faces.size()) == cells(0) * cells(1);
}

std::vector<std::size_t> ParameterLattice::kept(std::size_t axis, std::size_t stride) const {
  const std::size_t last = values_[axis].size() - 1;
  const std::size_t step = std::min(stride, std::max<std::size_t>(last / kLeastCells, 1));
  std::vector<std::size_t> kept;
  for (std::size_t i = 0; i < last; i += step) kept.push_back(i);
  kept.push_back(last);
  return kept;
}

std::size_t ParameterLattice::nodes(std::size_t stride) const {
  return kept(0, stride).size() * kept(1, stride).size();
}

ShownMesh ParameterLattice::every(std::size_t stride) const {
  const std::vector<std::size_t> columns = kept(0, stride), rows = kept(1, stride);
  ShownMesh shown;
  std::vector<std::int32_t> place(nodes_.size(), -1);  // of a node among those shown
  for (const std::size_t j : rows) {
    for (const std::size_t i : columns) shown.numbers.push_back(node(i, j));
  }
  std::ranges::sort(shown.numbers);
  shown.is_whole = shown.numbers.size() == nodes_.size();
  shown.parameters.resize(static_cast<Index>(shown.numbers.size()), 2);
  for (std::size_t k = 0; k < shown.numbers.size(); ++k) {
    place[static_cast<std::size_t>(shown.numbers[k])] = static_cast<std::int32_t>(k);
    shown.parameters.row(static_cast<Index>(k)) = mesh_->parameters.row(shown.numbers[k]);
  }
  const auto shown_node = [&](std::size_t i, std::size_t j) {
    return place[static_cast<std::size_t>(
        node(columns[i % columns.size()], rows[j % rows.size()]))];
  };
  for (std::size_t j = 0; j + (joined_[1] ? 0 : 1) < rows.size(); ++j) {
    for (std::size_t i = 0; i + (joined_[0] ? 0 : 1) < columns.size(); ++i) {
      std::array corners{shown_node(i, j), shown_node(i + 1, j), shown_node(i + 1, j + 1),
                         shown_node(i, j + 1)};
      if (turned_) std::swap(corners[1], corners[3]);
      shown.faces.nodes.insert(shown.faces.nodes.end(), corners.begin(), corners.end());
      shown.faces.begin.push_back(static_cast<std::int32_t>(shown.faces.nodes.size()));
    }
  }
  return shown;
}

ShownMesh whole(const TrajectoryMesh& mesh) {
  ShownMesh shown;
  shown.numbers.resize(static_cast<std::size_t>(mesh.areas.size()));
  std::iota(shown.numbers.begin(), shown.numbers.end(), 0);
  shown.parameters = mesh.parameters;
  shown.faces = mesh.faces;
  return shown;
}

}  // namespace deform
