/// Jets moved a little, for numerical derivatives of densities and stresses.
#pragma once

#include <algorithm>
#include <vector>

#include "deform/geometry/geometry.h"

#include "geometry/sample_geometry.h"

namespace deform {

inline constexpr std::size_t kJetComponents = 15;  // 5 derivatives of 3 components
/// Central differences of a smooth function: rounding and truncation errors balance near ε^(1/3).
inline constexpr double kRelativeStep = 6e-6;

/// A copy of a block's geometry with one component of one derivative moved at every sample.
class MovedBlock {
 public:
  explicit MovedBlock(const GeometryBlock& block)
      : block_(block), data_(static_cast<std::size_t>(GeometryBlock::kFields * block.size())) {}

  /// Moves component c of derivative m by `step` times its sample's scale.
  void move(std::size_t m, int c, double step) {
    for (Index s = 0; s < block_.size(); ++s) {
      SampleGeometry g = at(s);
      // Where the frame is not that of r_1 and r_2, the normal does not follow them.
      const bool follows = g.jet[0].cross(g.jet[1]).squaredNorm() > 0;
      g.jet[m][c] += step * scale(m, s);
      if (follows && m < 2) g.n = unit_normal(g.jet[0], g.jet[1]);
      write_sample(data_.data(), block_.size(), s, g);
    }
  }
  [[nodiscard]] double scale(std::size_t m, Index s) const {
    return std::max(1.0, block_.r(static_cast<Derivative>(m + 1))[s].norm());
  }
  /// The view keeps the block's place in its set, so that a term finds its own per-sample data.
  [[nodiscard]] GeometryBlock view() const {
    return {data_.data() - block_.first(), block_.size(), block_.first(), block_.size()};
  }

 private:
  [[nodiscard]] SampleGeometry at(Index s) const {
    SampleGeometry g;
    for (std::size_t m = 0; m < 5; ++m) g.jet[m] = block_.r(static_cast<Derivative>(m + 1))[s];
    g.n = block_.n()[s];
    return g;
  }
  const GeometryBlock& block_;
  std::vector<double> data_;
};

}  // namespace deform
