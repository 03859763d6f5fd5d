#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <vector>

#include "deform/record/trajectory.h"

#include "compare/mesh_map.h"
#include "report/shown_mesh.h"

namespace deform {

/// The frames of a trajectory that a report shows, at the nodes that it shows.
class VariantFrames {
 public:
  /// `mesh` is that of the report, `shown` what is shown of it, `frames` the trajectory's. A
  /// trajectory on another mesh is interpolated at the parameters of the shown nodes. Throws
  /// InputError when the file is not a trajectory, or its surface does not reach to all nodes.
  VariantFrames(const std::filesystem::path& file, const TrajectoryMesh& mesh,
                const ShownMesh& shown, std::vector<std::size_t> frames);

  [[nodiscard]] std::size_t size() const { return frames_.size(); }
  /// Whether it lives on another mesh.
  [[nodiscard]] bool is_mapped() const { return map_.has_value(); }
  [[nodiscard]] const std::vector<TrajectoryField>& fields() const { return trajectory_.fields(); }
  /// (shown nodes × 3) [m] of the i-th frame.
  [[nodiscard]] NodeVectors positions(std::size_t i) const;
  /// (shown nodes) of the i-th frame.
  [[nodiscard]] std::vector<float> field(std::size_t i, std::size_t field) const;

 private:
  Trajectory trajectory_;
  const ShownMesh& shown_;
  std::vector<std::size_t> frames_;
  std::optional<MeshMap> map_;
};

}  // namespace deform
