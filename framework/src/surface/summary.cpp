#include "deform/surface/summary.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "deform/geometry/geometry.h"

namespace deform {
namespace {

constexpr double kDegrees = 180 / 3.14159265358979323846;

/// Takes numbers one by one.
class RangeOf {
 public:
  explicit RangeOf(Range& range) : range_(&range) {}
  void add(double value) {
    range_->least = std::min(range_->least, value);
    range_->largest = std::max(range_->largest, value);
    ++count_;
    range_->mean += (value - range_->mean) / static_cast<double>(count_);
  }

 private:
  Range* range_;
  long count_ = 0;
};

double angle_between(const Vec3& u, const Vec3& v) {
  return kDegrees * std::atan2(u.cross(v).norm(), u.dot(v));
}

/// Area and least angles; triangles of polygons.
void measure_faces(const Surface& surface, SurfaceSummary& summary) {
  const Faces& faces = surface.faces();
  const NodeVectors& r = surface.rest();
  std::set<std::pair<Index, Index>> edges;
  RangeOf angles(summary.angle), lengths(summary.edge);
  for (std::size_t f = 0; f + 1 < faces.begin.size(); ++f) {
    const auto begin = static_cast<std::size_t>(faces.begin[f]),
               end = static_cast<std::size_t>(faces.begin[f + 1]);
    for (std::size_t c = begin; c < end; ++c) {
      const Index a = faces.nodes[c], b = faces.nodes[c + 1 < end ? c + 1 : begin];
      if (edges.emplace(std::min(a, b), std::max(a, b)).second)
        lengths.add((r.row(a) - r.row(b)).norm());
    }
    for (std::size_t c = begin + 2; c < end; ++c) {
      const Vec3 p = r.row(faces.nodes[begin]), q = r.row(faces.nodes[c - 1]),
                 s = r.row(faces.nodes[c]);
      summary.area += 0.5 * (q - p).cross(s - p).norm();
      angles.add(std::min(
          {angle_between(q - p, s - p), angle_between(s - q, p - q), angle_between(p - s, q - s)}));
    }
  }
  summary.edges = static_cast<Index>(edges.size());
}

/// H = (B_11 G_22 − 2 B_12 G_12 + B_22 G_11)/(2 det G), K = det B/det G.
void measure_curvature(const Surface& surface, SurfaceSummary& summary) {
  const SampleSet& samples = surface.samples(SampleRole::bending);
  Geometry geometry(samples);
  geometry.compute(samples, surface.rest());
  const GeometryBlock g = geometry.all();
  RangeOf mean(summary.mean_curvature), gaussian(summary.gaussian_curvature);
  for (std::size_t s = 0; s < static_cast<std::size_t>(g.size()); ++s) {
    const double G_11 = g.G(Pair::p11)[s], G_12 = g.G(Pair::p12)[s], G_22 = g.G(Pair::p22)[s],
                 B_11 = g.B(Pair::p11)[s], B_12 = g.B(Pair::p12)[s], B_22 = g.B(Pair::p22)[s];
    const double det = G_11 * G_22 - G_12 * G_12;
    if (!(det > 0)) continue;
    mean.add(std::abs(B_11 * G_22 - 2 * B_12 * G_12 + B_22 * G_11) / (2 * det));
    gaussian.add((B_11 * B_22 - B_12 * B_12) / det);
  }
}

}  // namespace

SurfaceSummary summary_of(const Surface& surface) {
  SurfaceSummary summary;
  summary.nodes = surface.nodes();
  summary.faces = surface.faces().size();
  summary.has_chart = surface.has_chart();
  for (const std::string& name : surface.boundary_names())
    summary.borders.push_back({name, static_cast<Index>(surface.boundary(name).size())});
  summary.lower = surface.rest().colwise().minCoeff();
  summary.upper = surface.rest().colwise().maxCoeff();
  measure_faces(surface, summary);
  summary.euler_characteristic = summary.nodes - summary.edges + summary.faces;
  measure_curvature(surface, summary);
  return summary;
}

}  // namespace deform
