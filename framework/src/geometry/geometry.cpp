#include "deform/geometry/geometry.h"

#include <algorithm>

#include "deform/kernel.h"
#include "deform/parallel.h"
#include "deform/surface/sample_set.h"

#include "geometry/sample_geometry.h"

namespace deform {
namespace {

/// out[i] += d x[i].
DEFORM_KERNEL void add(Index size, double d, const double* __restrict x, double* __restrict out) {
  for (Index i = 0; i < size; ++i) out[i] += d * x[i];
}

/// r_1, r_2, r_11, r_12, r_22: the operators' rows applied to the positions, for samples of a run.
void write_jets(const SampleSet& samples, const NodeVectors& r, double* data, Index stride,
                Index first, Index size) {
  const SampleSet::Stencil at = samples.stencil(first);
  for (int m = 1; m < kDerivatives; ++m)
    for (int c = 0; c < 3; ++c) {
      double* out = data + (3 * (m - 1) + c) * stride + first;
      std::fill_n(out, size, 0.0);
      for (std::size_t k = 0; k < at.nodes.size(); ++k)
        if (const double d = at.d[k][static_cast<std::size_t>(m)]; d != 0)
          add(size, d, r.col(c).data() + at.nodes[k], out);
    }
}

}  // namespace

Geometry::Geometry(const SampleSet& samples)
    : size_(samples.size()),
      stride_(samples.stride()),
      data_(static_cast<std::size_t>(GeometryBlock::kFields * stride_)) {}

void Geometry::compute(const SampleSet& samples, const NodeVectors& r) {
  parallel_blocks(size_, kBlock, [&](Index first, Index size) {
    const auto& frames = samples.frames();
    samples.visit_runs(first, size, [&](Index begin, Index count) {
      write_jets(samples, r, data_.data(), stride_, begin, count);
    });
    write_normals(data_.data(), stride_, first, size);
    auto frame = std::lower_bound(frames.begin(), frames.end(), first,
                                  [](const SampleSet::Frame& f, Index s) { return f.sample < s; });
    for (; frame != frames.end() && frame->sample < first + size; ++frame) {
      Vec3 t_1 = Vec3::Zero(), t_2 = Vec3::Zero();
      for (const SampleStencil::FrameEntry& entry : frame->entries) {
        t_1 += entry.d[0] * r.row(entry.node).transpose();
        t_2 += entry.d[1] * r.row(entry.node).transpose();
      }
      const Vec3 n = unit_normal(t_1, t_2);
      for (int c = 0; c < 3; ++c)
        data_[static_cast<std::size_t>((GeometryBlock::kNormal + c) * stride_ + frame->sample)] =
            n[c];
    }
    write_forms(data_.data(), stride_, first, size);
  });
}

void Geometry::blend(double s, const Geometry& other) {
  for (std::size_t i = 0; i < data_.size(); ++i) data_[i] = (1 - s) * data_[i] + s * other.data_[i];
}

}  // namespace deform
