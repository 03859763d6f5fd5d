/// Constants of Newton's method that more than one part of it goes by.
#pragma once

namespace deform {

/// Forces that cancel to this part of what they are made of count as balanced where no step helps.
inline constexpr double kRoundingOfForces = 1e-6;
/// Part of a direction's error that an iterative solver may leave.
inline constexpr double kForcing = 0.02;

}  // namespace deform
