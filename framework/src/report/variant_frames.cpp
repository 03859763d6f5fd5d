#include "report/variant_frames.h"

#include <utility>

namespace deform {

VariantFrames::VariantFrames(const std::filesystem::path& file, const TrajectoryMesh& mesh,
                             const ShownMesh& shown, std::vector<std::size_t> frames)
    : trajectory_(file), shown_(shown), frames_(std::move(frames)) {
  const Eigen::MatrixX2d& own = trajectory_.mesh().parameters;
  const bool is_same = own.rows() == mesh.parameters.rows() && own == mesh.parameters;
  if (!is_same) map_.emplace(trajectory_.mesh(), shown.parameters);
}

NodeVectors VariantFrames::positions(std::size_t i) const {
  NodeVectors all = trajectory_.positions(frames_[i]);
  if (map_) return map_->apply(all);
  if (shown_.is_whole) return all;
  NodeVectors some(static_cast<Index>(shown_.numbers.size()), 3);
  for (Index k = 0; k < some.rows(); ++k)
    some.row(k) = all.row(shown_.numbers[static_cast<std::size_t>(k)]);
  return some;
}

std::vector<float> VariantFrames::field(std::size_t i, std::size_t field) const {
  std::vector<float> all = trajectory_.field(frames_[i], field);
  if (map_) return map_->apply_nearest(all);
  if (shown_.is_whole) return all;
  std::vector<float> some;
  some.reserve(shown_.numbers.size());
  for (const std::int32_t number : shown_.numbers)
    some.push_back(all[static_cast<std::size_t>(number)]);
  return some;
}

}  // namespace deform
