/// Which nodes share a face: where the tangents of forces on faces have blocks.
#pragma once

#include <map>
#include <span>
#include <utility>
#include <vector>

#include <deform/surface/surface.h>

namespace deform {

/// All pairs (c, d) of a face's corners, face by face, whose nodes ascend or are the same, and the
/// pairs of nodes that they are.
class PairsOfCorners {
 public:
  /// `faces` must outlive this.
  explicit PairsOfCorners(const Faces& faces) : faces_(faces) {
    std::map<std::pair<Index, Index>, std::size_t> number;
    visit_corners([&](std::span<const std::int32_t> face, std::size_t c, std::size_t d) {
      const auto [at, is_new] = number.try_emplace({face[c], face[d]}, nodes_.size());
      if (is_new) nodes_.push_back(at->first);
      pair_.push_back(at->second);
    });
  }

  /// The pairs of nodes, each once: ForceField::tangent_pairs.
  [[nodiscard]] const std::vector<std::pair<Index, Index>>& nodes() const { return nodes_; }

  /// Calls visit(number in nodes(), face, c, d).
  template <class Visit>
  void visit(const Visit& visit) const {
    auto pair = pair_.begin();
    visit_corners([&](std::span<const std::int32_t> face, std::size_t c, std::size_t d) {
      visit(*pair++, face, c, d);
    });
  }

 private:
  template <class Visit>
  void visit_corners(const Visit& visit) const {
    for (std::size_t f = 0; f + 1 < faces_.begin.size(); ++f) {
      const auto first = static_cast<std::size_t>(faces_.begin[f]);
      const std::span<const std::int32_t> face(
          faces_.nodes.data() + first, static_cast<std::size_t>(faces_.begin[f + 1]) - first);
      for (std::size_t c = 0; c < face.size(); ++c)
        for (std::size_t d = 0; d < face.size(); ++d)
          if (face[c] <= face[d]) visit(face, c, d);
    }
  }

  const Faces& faces_;
  std::vector<std::pair<Index, Index>> nodes_;
  std::vector<std::size_t> pair_;  // in nodes_, of what visit_corners visits
};

}  // namespace deform
