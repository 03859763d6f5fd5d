/// Trajectories: the recorded states of a run, which comparisons and reports are made of.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "deform/export.h"
#include "deform/surface/surface.h"
#include "deform/types.h"

namespace deform {

/// Its name within a run directory.
inline constexpr const char* kTrajectoryFile = "trajectory.bin";

/// A number a node, recorded with the positions.
struct TrajectoryField {
  /// How its numbers are to be read: from zero up, on both sides of zero, or as numbers of labels.
  enum class Scale : std::uint8_t { sequential, diverging, categorical };
  std::string name;  ///< "B_11", "energy density, bending"
  std::string unit;
  Scale scale = Scale::sequential;
  std::vector<std::string> labels{};  ///< of categorical ones
};

/// The surface that a trajectory is of.
struct TrajectoryMesh {
  Eigen::MatrixX2d parameters;  ///< (N × 2) (a1, a2) [m]
  NodeValues areas;             ///< (N) of each node, that mass goes by [m²]
  Faces faces;
  double size = 0;  ///< largest side of the rest state's bounding box [m]
};

/// A recorded state: steps done, time [s].
struct Moment {
  long step = 0;
  double time = 0;
};

/// Reads trajectory.bin of a run directory; frames are read when they are asked for.
///
/// The file, little-endian: the line "deform trajectory 1", the length of what follows up to the
/// mesh (8 bytes), JSON with the numbers of nodes, faces and corners, `size` and `fields`, and of
/// scalar unknowns where there are any (`scalars`); the mesh: parameters (all a1, all a2), areas,
/// the faces' `begin` and `nodes` (int32); then the frames: step (int64), time, positions (all x,
/// all y, all z; doubles), a float a node for each field, and a double for each scalar unknown.
class DEFORM_API Trajectory {
 public:
  /// Throws InputError naming the file and the reason when it is not there or not a trajectory: a
  /// count, a corner or a moment is not what it can be. A last frame that is cut off does not
  /// count.
  explicit Trajectory(std::filesystem::path file);

  [[nodiscard]] const TrajectoryMesh& mesh() const { return mesh_; }
  [[nodiscard]] const std::vector<TrajectoryField>& fields() const { return fields_; }
  /// In ascending order.
  [[nodiscard]] const std::vector<Moment>& moments() const { return moments_; }
  [[nodiscard]] std::size_t frames() const { return moments_.size(); }
  /// (N × 3) [m], finite. Throws InputError when the file cannot be read any more or is damaged.
  [[nodiscard]] NodeVectors positions(std::size_t frame) const;
  /// (S) the model's scalar unknowns (System::scalars); finite.
  [[nodiscard]] NodeValues scalars(std::size_t frame) const;
  /// (N) in the field's unit; not finite where there is no figure.
  [[nodiscard]] std::vector<float> field(std::size_t frame, std::size_t field) const;

 private:
  void read_header();
  void read_mesh(std::size_t nodes, std::size_t faces, std::size_t corners);
  void check_mesh() const;
  void find_moments();
  [[nodiscard]] std::size_t place_of(std::size_t frame) const;
  void read_finite(std::size_t frame, std::size_t offset, double* to, std::size_t count,
                   const char* what) const;
  void read(std::size_t at, void* to, std::size_t bytes) const;
  [[nodiscard]] std::size_t nodes() const { return static_cast<std::size_t>(mesh_.areas.size()); }
  [[nodiscard]] std::size_t frame_bytes() const;

  std::filesystem::path path_;
  mutable std::ifstream file_;
  TrajectoryMesh mesh_;
  std::vector<TrajectoryField> fields_;
  std::size_t scalars_ = 0;
  std::vector<Moment> moments_;
  std::uintmax_t bytes_ = 0;     // of the file
  std::size_t first_frame_ = 0;  // bytes before it
};

}  // namespace deform
