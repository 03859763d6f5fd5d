/// How a grid's nodes are numbered and where its cells are.
#pragma once

#include <array>

#include <deform/surface/surface.h>

namespace grid {

using deform::Index;

/// n[0] × n[1] nodes at the spacings h [m]; a direction that is periodic has as many cells as
/// nodes.
struct Lattice {
  std::array<Index, 2> n{};
  std::array<double, 2> h{};
  std::array<bool, 2> periodic{};

  [[nodiscard]] Index nodes() const { return n[0] * n[1]; }
  [[nodiscard]] Index node(Index i, Index j) const { return i + n[0] * j; }
  /// Number of cells along a direction, 0 or 1.
  [[nodiscard]] Index cells(std::size_t direction) const {
    return periodic[direction] ? n[direction] : n[direction] - 1;
  }
  [[nodiscard]] deform::Vec2 parameter(Index i, Index j) const {
    return {static_cast<double>(i) * h[0], static_cast<double>(j) * h[1]};
  }
  /// The number of spacings that line i stands for: a half at an open end, else one.
  [[nodiscard]] double share(std::size_t direction, Index i) const {
    return !periodic[direction] && (i == 0 || i == n[direction] - 1) ? 0.5 : 1.0;
  }
};

/// (N × 2) [m].
[[nodiscard]] Eigen::MatrixX2d parameters(const Lattice& lattice);
/// (N) [m²]: the area that each node stands for, or that of a cell.
enum class Weights { equal, area };
[[nodiscard]] deform::NodeValues areas(const Lattice& lattice, Weights weights);
/// The cells.
[[nodiscard]] deform::Faces faces(const Lattice& lattice);
/// Nodes of the side "left", "right", "bottom" or "top", ascending; empty where it is joined or no
/// side.
[[nodiscard]] std::vector<Index> side(const Lattice& lattice, const std::string& name);

}  // namespace grid
