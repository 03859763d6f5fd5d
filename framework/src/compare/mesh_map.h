/// What lies on one surface at the nodes of another: the two are compared at equal parameters.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "deform/record/trajectory.h"

namespace deform {

/// Whether nodes have parameters that tell them apart (Surface::has_chart).
[[nodiscard]] bool has_chart(const TrajectoryMesh& mesh);

/// Interpolates what is given at the nodes of one mesh (linearly within the triangles of its faces
/// in the parameter plane) at given parameters. Nodes of the mesh itself are hit exactly, with no
/// arithmetic.
class MeshMap {
 public:
  /// Throws InputError when a place lies outside the mesh by more than 1e-9 of its extent.
  MeshMap(const TrajectoryMesh& mesh, const Eigen::MatrixX2d& places);

  /// True when place i is node i for every i, and there are no other nodes.
  [[nodiscard]] bool is_identity() const { return identity_; }
  /// (N × 3) at the nodes to (M × 3) at the places.
  [[nodiscard]] NodeVectors apply(const NodeVectors& values) const;
  /// The value of the node with the largest weight: for labels and fields that are only looked at.
  [[nodiscard]] std::vector<float> apply_nearest(const std::vector<float>& values) const;

 private:
  struct Row {
    std::array<std::int32_t, 3> nodes{};
    std::array<double, 3> weights{};
  };
  std::vector<Row> rows_;  // a place each; weight 0: the node does not count
  bool identity_ = false;
};

}  // namespace deform
