/// What somebody wants to know of a surface before it is used.
#pragma once

#include <string>
#include <vector>

#include "deform/export.h"
#include "deform/surface/surface.h"

namespace deform {

/// Least, mean and largest of some numbers.
struct Range {
  double least = kInfinity, mean = 0, largest = -kInfinity;
};

/// Of a surface at rest; its faces as triangles, polygons cut from their first corner.
struct SurfaceSummary {
  struct Border {
    std::string name;
    Index nodes = 0;
  };
  Index nodes = 0, faces = 0, edges = 0;
  /// Vertices less edges plus faces: 2 of a sphere, 1 of a disc, 0 of a torus or an open cylinder.
  Index euler_characteristic = 0;
  bool has_chart = true;
  std::vector<Border> borders;
  double area = 0;            ///< [m²]
  Vec3 lower = Vec3::Zero();  ///< corners of the box that it is in [m]
  Vec3 upper = Vec3::Zero();
  Range edge;                ///< lengths [m]
  Range angle;               ///< least one of each triangle [degrees]
  Range mean_curvature;      ///< |H| at bending samples [1/m]
  Range gaussian_curvature;  ///< K there [1/m²]
};
[[nodiscard]] DEFORM_API SurfaceSummary summary_of(const Surface& surface);

}  // namespace deform
