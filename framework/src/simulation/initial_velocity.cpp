#include "simulation/initial_velocity.h"

#include <utility>
#include <vector>

#include <Eigen/Geometry>

#include "deform/error.h"
#include "deform/surface/surface.h"

namespace deform {
namespace {

NodeVectors linear_part(const InitialVelocity& velocity, const Surface& surface) {
  NodeVectors v(surface.parameters().rows(), 3);
  try {
    for (const int c : {0, 1, 2})
      v.col(c) = velocity.linear[static_cast<std::size_t>(c)].at_nodes(surface);
  } catch (const InputError& e) {
    std::vector<Problem> placed;
    for (const Problem& problem : e.problems())
      placed.push_back({problem.pointer, "at " + problem.pointer + ": " + problem.message});
    throw InputError(std::move(placed));
  }
  return v;
}

}  // namespace

NodeVectors velocities_at_first(const InitialVelocity& velocity, const Surface& surface,
                                const NodeValues& mass, const NodeVectors& r) {
  NodeVectors v = linear_part(velocity, surface);
  if (velocity.spin.isZero(0)) return v;
  const Vec3 about = velocity.about.value_or((r.transpose() * mass / mass.sum()).eval());
  for (Index a = 0; a < r.rows(); ++a)
    v.row(a) += velocity.spin.cross(Vec3(r.row(a).transpose() - about)).transpose();
  return v;
}

}  // namespace deform
