/// Rectangles of the parameters that selections describe.
#pragma once

#include <optional>

#include "deform/surface/surface.h"

namespace deform {

/// The rectangle that a selector takes by parameters, closed; none for nodes by number or name.
[[nodiscard]] std::optional<ParameterRectangle> rectangle_of(const NodeSelector& selector);

/// Whether a rectangle is a patch, which has an area, rather than a line or a point.
[[nodiscard]] bool is_patch(const ParameterRectangle& rectangle);

/// Whether parameters are within, on the rim (whatever their rounding) included. On a joined side
/// the rectangle may reach over the seam.
[[nodiscard]] bool contains(const ParameterRectangle& rectangle, const Vec2& a, const Vec2& period);

}  // namespace deform
