/// Which corners of which faces each node is.
#pragma once

#include <span>
#include <vector>

#include <deform/surface/surface.h>

namespace deform {

/// Forces on faces are gathered node by node: a node asks each face that it belongs to for its
/// part, in ascending order of the faces. Sums then have the same bits however the nodes are cut
/// into blocks, at the price of looking at a face once a corner.
class CornersOfNodes {
 public:
  /// One corner of one polygon.
  struct Corner {
    std::span<const std::int32_t> face;  ///< the polygon's nodes, counter-clockwise
    std::size_t place = 0;               ///< of the node among them
  };

  explicit CornersOfNodes(const Surface& surface) : faces_(surface.faces()) {
    const auto nodes = static_cast<std::size_t>(surface.nodes());
    begin_.assign(nodes + 1, 0);
    for (const std::int32_t node : faces_.nodes) ++begin_[static_cast<std::size_t>(node) + 1];
    for (std::size_t a = 0; a < nodes; ++a) begin_[a + 1] += begin_[a];
    corners_.resize(faces_.nodes.size());
    std::vector<std::size_t> next(begin_.begin(), begin_.end() - 1);
    for (std::size_t f = 0; f + 1 < faces_.begin.size(); ++f) {
      const auto first = static_cast<std::size_t>(faces_.begin[f]),
                 last = static_cast<std::size_t>(faces_.begin[f + 1]);
      const std::span<const std::int32_t> face(faces_.nodes.data() + first, last - first);
      for (std::size_t c = 0; c < face.size(); ++c)
        corners_[next[static_cast<std::size_t>(face[c])]++] = {face, c};
    }
  }
  CornersOfNodes(const CornersOfNodes&) = delete;  // corners point into faces_
  CornersOfNodes& operator=(const CornersOfNodes&) = delete;

  [[nodiscard]] std::span<const Corner> of(Index node) const {
    const auto a = static_cast<std::size_t>(node);
    return {corners_.data() + begin_[a], begin_[a + 1] - begin_[a]};
  }
  [[nodiscard]] const Faces& faces() const { return faces_; }

 private:
  Faces faces_;
  std::vector<std::size_t> begin_;
  std::vector<Corner> corners_;
};

/// Mean of a field over a polygon's corners.
inline Vec3 mean(std::span<const std::int32_t> face, ConstVectors field) {
  Vec3 sum = Vec3::Zero();
  for (const std::int32_t node : face) sum += field[node];
  return sum / static_cast<double>(face.size());
}

/// Area vector of a polygon about a point near it, which changes it by rounding only: along the
/// side from which the corners go counter-clockwise, as long as the area is large [m²].
inline Vec3 area_vector(std::span<const std::int32_t> face, ConstVectors r, const Vec3& about) {
  Vec3 twice = Vec3::Zero();
  Vec3 last = r[face.back()] - about;
  for (const std::int32_t node : face) {
    const Vec3 next = r[node] - about;
    twice += last.cross(next);
    last = next;
  }
  return twice / 2;
}

}  // namespace deform
