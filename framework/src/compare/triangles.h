#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "deform/surface/surface.h"

namespace deform {

using Triangle = std::array<std::int32_t, 3>;

/// Fans of triangles over the polygons, orientation kept.
[[nodiscard]] std::vector<Triangle> triangles_of(const Faces& faces);

}  // namespace deform
