#include "deform/geometry/geometry.h"

#include <algorithm>
#include <array>
#include <limits>

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

/// Derivatives of the jet.
struct Derivatives {
  int begin, end;
};
constexpr Derivatives kFirst{1, 3}, kSecond{3, kDerivatives};

/// Some of r_1, r_2, r_11, r_12, r_22: the operators' rows applied to the positions, for samples of
/// a run.
void write_jets(const SampleSet& samples, const NodeVectors& r, Derivatives which, double* data,
                Index stride, Index first, Index size) {
  const SampleSet::Stencil at = samples.stencil(first);
  for (int m = which.begin; m < which.end; ++m)
    for (int c = 0; c < 3; ++c) {
      double* out = data + (3 * (m - 1) + c) * stride + first;
      std::fill_n(out, size, 0.0);
      for (std::size_t k = 0; k < at.nodes.size(); ++k)
        if (const double d = at.d[k][static_cast<std::size_t>(m)]; d != 0)
          add(size, d, r.col(c).data() + at.nodes[k], out);
    }
}

/// Normals along a frame of their own, where samples have one.
void write_framed_normals(const SampleSet& samples, const NodeVectors& r, double* data,
                          Index stride, Index first, Index size) {
  const auto& frames = samples.frames();
  auto frame = std::lower_bound(frames.begin(), frames.end(), first,
                                [](const SampleSet::Frame& f, Index s) { return f.sample < s; });
  for (; frame != frames.end() && frame->sample < first + size; ++frame) {
    Vec3 t_1 = Vec3::Zero(), t_2 = Vec3::Zero();
    for (const SampleStencil::FrameEntry& entry : frame->entries) {
      t_1 += entry.d[0] * r.row(entry.node).transpose();
      t_2 += entry.d[1] * r.row(entry.node).transpose();
    }
    const Vec3 n = unit_normal(t_1, t_2);
    for (int c = 0; c < 3; ++c) data[(GeometryBlock::kNormal + c) * stride + frame->sample] = n[c];
  }
}

/// Fields [begin, end) that each detail has beyond the one before it.
struct Fields {
  Geometry::Detail detail;
  int begin, end;
};
constexpr std::array<Fields, 8> kFieldsOf{
    {{Geometry::Detail::metric, 0, 3 * (kSecond.begin - 1)},
     {Geometry::Detail::metric, GeometryBlock::kMetric, GeometryBlock::kCurvature},
     {Geometry::Detail::first, GeometryBlock::kNormal, GeometryBlock::kMetric},
     {Geometry::Detail::first, GeometryBlock::kReciprocal, GeometryBlock::kChristoffel},
     {Geometry::Detail::first, GeometryBlock::kAreaElement, GeometryBlock::kFields},
     {Geometry::Detail::second, 3 * (kSecond.begin - 1), GeometryBlock::kNormal},
     {Geometry::Detail::second, GeometryBlock::kCurvature, GeometryBlock::kReciprocal},
     {Geometry::Detail::second, GeometryBlock::kChristoffel, GeometryBlock::kAreaElement}}};

}  // namespace

Geometry::Geometry(const SampleSet& samples)
    : size_(samples.size()),
      stride_(samples.stride()),
      data_(static_cast<std::size_t>(GeometryBlock::kFields * stride_),
            std::numeric_limits<double>::quiet_NaN()) {}

void Geometry::compute(const SampleSet& samples, const NodeVectors& r, Detail detail) {
  begin(detail);
  if (detail == Detail::none) return;
  parallel_blocks(size_, kBlock,
                  [&](Index first, Index size) { compute(samples, r, first, size); });
}

void Geometry::begin(Detail detail) {
  if (detail < detail_) leave_out(detail);
  detail_ = detail;
  has_mean_strains_ = false;
}

void Geometry::compute(const SampleSet& samples, const NodeVectors& r, Index first, Index size) {
  const auto write = [&](Derivatives which) {
    samples.visit_runs(first, size, [&](Index begin, Index count) {
      write_jets(samples, r, which, data_.data(), stride_, begin, count);
    });
  };
  if (detail_ == Detail::none) return;
  write(kFirst);
  if (detail_ == Detail::metric) return write_metric(data_.data(), stride_, first, size);
  write_normals(data_.data(), stride_, first, size);
  write_framed_normals(samples, r, data_.data(), stride_, first, size);
  write_metric_and_reciprocal(data_.data(), stride_, first, size);
  if (detail_ == Detail::first) return;
  write(kSecond);
  write_curvature(data_.data(), stride_, first, size);
}

void Geometry::complete(const SampleSet& samples, const NodeVectors& r) {
  if (detail_ != Detail::second) compute(samples, r);
}

/// What is not computed any more must not look as if it were.
void Geometry::leave_out(Detail beyond) {
  for (const Fields& fields : kFieldsOf)
    if (fields.detail > beyond)
      std::fill_n(data_.begin() + fields.begin * stride_, (fields.end - fields.begin) * stride_,
                  std::numeric_limits<double>::quiet_NaN());
}

void Geometry::make_mean(const Geometry& middle, const Geometry& from, const Geometry& to) {
  size_ = middle.size_, stride_ = middle.stride_, detail_ = middle.detail_;
  data_.resize(middle.data_.size());
  has_mean_strains_ = true;
  parallel_blocks(size_, kBlock, [&](Index first, Index size) {
    for (int field = 0; field < GeometryBlock::kFields; ++field)
      std::copy_n(middle.data_.data() + field * stride_ + first, size,
                  data_.data() + field * stride_ + first);
    const MeanOf ends{from.data_.data(), to.data_.data()};
    if (detail_ == Detail::none) return;
    write_mean_metric(ends, data_.data(), stride_, first, size);
    if (detail_ >= Detail::first) write_mean_normals(ends, data_.data(), stride_, first, size);
    if (detail_ == Detail::second) write_mean_curvature(ends, data_.data(), stride_, first, size);
  });
}

void Geometry::average_forms(const Geometry& other) {
  has_mean_strains_ = true;
  for (int field = GeometryBlock::kMetric; field < GeometryBlock::kReciprocal; ++field)
    for (Index i = field * stride_; i < field * stride_ + size_; ++i) {
      const auto at = static_cast<std::size_t>(i);
      data_[at] = 0.5 * (data_[at] + other.data_[at]);
    }
}

void Geometry::blend(double s, const Geometry& other) {
  for (std::size_t i = 0; i < data_.size(); ++i) data_[i] = (1 - s) * data_[i] + s * other.data_[i];
}

}  // namespace deform
