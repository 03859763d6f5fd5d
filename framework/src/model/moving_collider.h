/// Colliders that a scene moves.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "deform/model/collider.h"
#include "deform/types.h"

namespace deform {

/// Where a rigid body is over time: x = p + u(t) + R(t) (X − p) for what is at X before it moves.
/// u [m] and the rotation vector of R (axis times angle [rad]) are linear between the times, and
/// constant before and after: about one axis a body turns evenly, by any number of turns.
struct RigidPath {
  std::vector<double> times{};                     ///< [s], ascending
  std::vector<Vec3> displacements{}, rotations{};  ///< one for each time; either may be empty: none
  Vec3 pivot = Vec3::Zero();                       ///< p [m]
};

/// What is wrong with a path, its parameters named; "" where nothing is.
[[nodiscard]] std::string problem_of(const RigidPath& path);

/// A collider that moves along a path, and by itself, if it does, beside that.
[[nodiscard]] std::shared_ptr<Collider> moving(std::shared_ptr<Collider> collider, RigidPath path);

}  // namespace deform
