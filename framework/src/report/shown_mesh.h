/// The nodes and faces that a report shows: all of a mesh, or fewer where that would be too much.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "deform/record/trajectory.h"

namespace deform {

struct ShownMesh {
  std::vector<std::int32_t> numbers;  ///< the mesh's number of each shown node, ascending
  Eigen::MatrixX2d parameters;        ///< (shown nodes × 2)
  Faces faces;                        ///< over the shown nodes
  bool is_whole = true;               ///< every node of the mesh is shown
};

/// A mesh of four-cornered faces whose nodes' parameters are all pairs of some a1 with some a2, in
/// any order: rows and columns of it can be left out.
class ParameterLattice {
 public:
  /// Nothing where the mesh is not of that kind.
  [[nodiscard]] static std::optional<ParameterLattice> of(const TrajectoryMesh& mesh);

  /// Nodes that stay with every `stride`-th value of a1 and of a2.
  [[nodiscard]] std::size_t nodes(std::size_t stride) const;
  /// The mesh of those nodes. The outermost values stay, and some between them along a short side.
  [[nodiscard]] ShownMesh every(std::size_t stride) const;

 private:
  explicit ParameterLattice(const TrajectoryMesh& mesh) : mesh_(&mesh) {}
  [[nodiscard]] bool place_nodes();
  [[nodiscard]] bool has_all_faces();
  [[nodiscard]] std::vector<std::size_t> kept(std::size_t axis, std::size_t stride) const;
  [[nodiscard]] std::int32_t& node(std::size_t i, std::size_t j) {
    return nodes_[j * values_[0].size() + i];
  }
  [[nodiscard]] std::int32_t node(std::size_t i, std::size_t j) const {
    return nodes_[j * values_[0].size() + i];
  }

  const TrajectoryMesh* mesh_;
  std::array<std::vector<double>, 2> values_;     // of a1 and of a2, ascending
  std::array<std::vector<std::size_t>, 2> rank_;  // of each node's a1 and a2 among them
  std::vector<std::int32_t> nodes_;               // by the ranks of a2, then of a1
  std::array<bool, 2> joined_{};                  // the last value is a neighbour of the first
  bool turned_ = false;                           // faces run clockwise in the (a1, a2) plane
};

/// The mesh as it is.
[[nodiscard]] ShownMesh whole(const TrajectoryMesh& mesh);

}  // namespace deform
