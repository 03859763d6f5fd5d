/// Constants of Newton's method that more than one part of it goes by.
#pragma once

namespace deform {

/// Forces that cancel to this part of what they are made of count as balanced where no step helps.
inline constexpr double kRoundingOfForces = 1e-6;
/// A step below this part of the size, and the rounding of positions, moves nothing: what is left
/// of the residual is the rounding of forces, of which some are far larger than all that is at
/// work.
inline constexpr double kRoundingOfPositions = 1e-13;
/// Residuals, relative to the forces at work, that are close to a solution's: farther from one,
/// forces that no symmetric tangent knows are not worth looking at.
inline constexpr double kClose = 0.2;
/// Part of a direction's error that an iterative solver may leave.
inline constexpr double kForcing = 0.02;

}  // namespace deform
