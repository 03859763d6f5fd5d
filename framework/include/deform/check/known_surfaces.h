/// Surfaces whose normals are known in closed form.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "deform/export.h"
#include "deform/types.h"

namespace deform {

/// A parametrised surface over the unit square: positions [m] and unit normals at (a1, a2).
struct KnownSurface {
  std::string name;
  std::function<Vec3(double, double)> r, n;
};

/// A patch of a sphere, a cylinder, one with an uneven parameter, a paraboloid, a saddle.
[[nodiscard]] DEFORM_API std::vector<KnownSurface> known_surfaces();

/// Angle between two directions, 0 to π, exact for small ones too.
[[nodiscard]] DEFORM_API double angle(const Vec3& a, const Vec3& b);

}  // namespace deform
