/// The step of central differences of forces.
#pragma once

namespace deform {

/// Relative to the surface's size: rounding and truncation are in balance there.
inline constexpr double kDifferenceStep = 1e-6;

}  // namespace deform
