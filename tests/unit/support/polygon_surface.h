/// Any polygons as a surface, for tests of what needs only nodes and faces.
#pragma once

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "deform/surface/surface.h"

namespace deform::test {

class PolygonSurface final : public Surface {
 public:
  /// `r` (N × 3) are the rest positions [m].
  PolygonSurface(const NodeVectors& r, const std::vector<std::vector<std::int32_t>>& polygons)
      : parameters_(r.leftCols(2)), areas_(NodeValues::Ones(r.rows())), rest_(r) {
    for (const auto& polygon : polygons) {
      faces_.nodes.insert(faces_.nodes.end(), polygon.begin(), polygon.end());
      faces_.begin.push_back(static_cast<std::int32_t>(faces_.nodes.size()));
    }
  }

  [[nodiscard]] Index nodes() const override { return rest_.rows(); }
  [[nodiscard]] const Eigen::MatrixX2d& parameters() const override { return parameters_; }
  [[nodiscard]] const NodeValues& areas() const override { return areas_; }
  [[nodiscard]] const NodeVectors& rest() const override { return rest_; }
  [[nodiscard]] const NodeVectors& initial() const override { return rest_; }
  [[nodiscard]] const Faces& faces() const override { return faces_; }
  [[nodiscard]] const SampleSet& samples(SampleRole /*role*/) const override { return samples_; }
  [[nodiscard]] std::vector<std::string> boundary_names() const override { return {}; }
  [[nodiscard]] std::vector<std::string> corner_names() const override { return {}; }
  [[nodiscard]] std::vector<Index> boundary(const std::string& /*name*/) const override {
    return {};
  }
  [[nodiscard]] std::vector<Index> corner(const std::string& /*name*/) const override { return {}; }

 private:
  Eigen::MatrixX2d parameters_;
  NodeValues areas_;
  NodeVectors rest_;
  Faces faces_;
  SampleSet samples_;
};

/// A torus of n1 × n2 quadrilaterals about the z axis, radii 1 and 0.4, n outwards.
inline PolygonSurface torus(int n1, int n2) {
  NodeVectors r(n1 * n2, 3);
  std::vector<std::vector<std::int32_t>> faces;
  for (int j = 0; j < n2; ++j)
    for (int i = 0; i < n1; ++i) {
      const double u = 2 * std::numbers::pi * i / n1, v = 2 * std::numbers::pi * j / n2;
      const double ring = 1 + 0.4 * std::cos(v);
      r.row(j * n1 + i) << ring * std::cos(u), ring * std::sin(u), 0.4 * std::sin(v);
      const int right = (i + 1) % n1, above = (j + 1) % n2;
      faces.push_back({j * n1 + i, j * n1 + right, above * n1 + right, above * n1 + i});
    }
  return {r, faces};
}

/// The upper half of a unit sphere: `rings` rings of `around` nodes (the first is the equator) with
/// quadrilaterals, and triangles about the pole; n outwards. `bottom`: closed by one polygon, too.
inline PolygonSurface hemisphere(int rings, int around, bool bottom) {
  NodeVectors r(rings * around + 1, 3);
  std::vector<std::vector<std::int32_t>> faces;
  const int pole = rings * around;
  for (int j = 0; j < rings; ++j)
    for (int i = 0; i < around; ++i) {
      const double u = 2 * std::numbers::pi * i / around, v = std::numbers::pi / 2 * j / rings;
      r.row(j * around + i) << std::cos(v) * std::cos(u), std::cos(v) * std::sin(u), std::sin(v);
      const int here = j * around + i, right = j * around + (i + 1) % around;
      if (j + 1 < rings)
        faces.push_back({here, right, right + around, here + around});
      else
        faces.push_back({here, right, pole});
    }
  r.row(pole) << 0, 0, 1;
  if (bottom) {
    faces.emplace_back();
    for (int i = around; i-- > 0;) faces.back().push_back(i);
  }
  return {r, faces};
}

}  // namespace deform::test
