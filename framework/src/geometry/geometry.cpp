#include "deform/geometry/geometry.h"

#include <algorithm>

#include "deform/surface/sample_set.h"

#include "geometry/sample_geometry.h"
#include "parallel/parallel.h"

namespace deform {
namespace {

/// r_1, r_2, r_11, r_12, r_22: the operators' rows applied to the positions.
std::array<Vec3, 5> jet_at(const SampleSet& samples, Index s, const NodeVectors& r) {
  std::array<Vec3, 5> jet;
  jet.fill(Vec3::Zero());
  const SampleSet::Stencil at = samples.stencil(s);
  for (std::size_t k = 0; k < at.nodes.size(); ++k) {
    const Vec3 position = r.row(at.nodes[k]);
    for (std::size_t m = 0; m < 5; ++m) jet[m] += at.d[k][m + 1] * position;
  }
  return jet;
}

}  // namespace

Geometry::Geometry(const SampleSet& samples)
    : size_(samples.size()),
      data_(static_cast<std::size_t>(GeometryBlock::kFields * samples.size())) {}

void Geometry::compute(const SampleSet& samples, const NodeVectors& r) {
  parallel_blocks(size_, kBlock, [&](Index first, Index size) {
    const auto& frames = samples.frames();
    auto frame = std::lower_bound(frames.begin(), frames.end(), first,
                                  [](const SampleSet::Frame& f, Index s) { return f.sample < s; });
    for (Index s = first; s < first + size; ++s) {
      SampleGeometry g;
      g.jet = jet_at(samples, s, r);
      if (frame != frames.end() && frame->sample == s) {
        Vec3 t_1 = Vec3::Zero(), t_2 = Vec3::Zero();
        for (const SampleStencil::FrameEntry& entry : frame->entries) {
          t_1 += entry.d[0] * r.row(entry.node).transpose();
          t_2 += entry.d[1] * r.row(entry.node).transpose();
        }
        g.n = unit_normal(t_1, t_2);
        ++frame;
      } else {
        g.n = unit_normal(g.jet[0], g.jet[1]);
      }
      write_sample(data_.data(), size_, s, g);
    }
  });
}

void Geometry::blend(double s, const Geometry& other) {
  for (std::size_t i = 0; i < data_.size(); ++i) data_[i] = (1 - s) * data_[i] + s * other.data_[i];
}

}  // namespace deform
