/// Triangles that make a surface: what is wrong with them, and what can be mended.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "polygons.h"

namespace mesh {

using Triangle = std::array<std::int32_t, 3>;

/// A border of the surface: its nodes one after another, the surface to their left.
using Loop = std::vector<Index>;

/// An orientable surface, with borders or closed: each edge has one or two triangles, which run
/// along it in opposite directions, and those around a node are one fan.
struct Triangles {
  deform::NodeVectors positions;  ///< (N × 3) [m]
  std::vector<Triangle> all;
  std::vector<std::string> group_names;
  std::vector<std::int32_t> group;  ///< of each triangle; −1: none
  std::vector<Loop> borders;        ///< the longest first

  [[nodiscard]] Index nodes() const { return positions.rows(); }
};

/// Cuts polygons of a file into triangles and checks them. Throws InputError with every problem
/// found, by the file's numbers from 0. `repairs`: what can be mended is (vertices at one place,
/// polygons that name a vertex twice or have no area, doubled ones, vertices that no polygon uses,
/// directions round polygons that their neighbours do not share), and `mended` says what was.
[[nodiscard]] Triangles make_triangles(Polygons polygons, const std::string& file, bool repairs,
                                       std::vector<std::string>& mended);

/// Twice the area times the normal of a triangle.
[[nodiscard]] deform::Vec3 doubled_area(const deform::NodeVectors& r, const Triangle& t);

}  // namespace mesh
