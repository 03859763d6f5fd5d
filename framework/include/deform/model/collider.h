/// Colliders: bodies that a surface stays outside of.
#pragma once

#include <algorithm>
#include <cmath>

#include "deform/plugin/descriptor.h"
#include "deform/types.h"

namespace deform {

/// A body by its signed distance. Contract: const and thread-safe on blocks of points; a pure
/// function of time and place; the normal is the distance's gradient.
class DEFORM_API Collider : public Plugin {
 public:
  static constexpr PluginKind kKind = PluginKind::collider;
  ~Collider() override;

  /// For each of distance.size() points [m] at a time [s]: the distance to the body's surface [m],
  /// negative inside, and the unit vector along which it grows fastest.
  virtual void measure(double time, ConstVectors points, Values distance, Vectors normal) const = 0;
  /// Whether the body, and so its distance as a function of place, is convex at all times: then few
  /// looks tell where a node that moves far within a step comes in. Where it may not be, more do.
  [[nodiscard]] virtual bool is_convex() const { return false; }
  /// For so many points of the body that are at `points` [m] at a time: where its motion has them
  /// at another one, earlier or later. What is friction's to resist is a node's motion beside this.
  /// Returns false, `carried` untouched, where the body does not move, as here: the surface of one
  /// that only grows or shrinks carries nothing along.
  [[nodiscard]] virtual bool carry(double from, double to, Index size, ConstVectors points,
                                   Vectors carried) const;
};

/// Distance and its gradient at one point.
struct SignedDistance {
  double distance = 0;
  Vec3 normal = Vec3::UnitZ();
};

/// Writes what f(point) says of each point.
template <class F>
void measure_each(ConstVectors points, Values distance, Vectors normal, const F& f) {
  for (std::size_t i = 0; i < distance.size(); ++i) {
    const SignedDistance d = f(points[static_cast<Index>(i)]);
    distance[i] = d.distance;
    normal.set(static_cast<Index>(i), d.normal);
  }
}

/// A box in two or three dimensions, about the origin, whose edges are rounded: what is within
/// `radius` of the box that is smaller by `radius` on each side. `gradient` has the same dimension.
template <class Vector>
double rounded_box_distance(const Vector& point, const Vector& half_size, double radius,
                            Vector& gradient) {
  const Vector beyond = point.cwiseAbs().array() - half_size.array() + radius;
  const Vector outside = beyond.cwiseMax(0.0);
  const double length = outside.norm();
  if (length > 0) {
    gradient = outside / length;
  } else {  // inside the smaller box: towards the nearest side
    Index side = 0;
    beyond.maxCoeff(&side);
    gradient = Vector::Unit(beyond.size(), side);
  }
  for (Index c = 0; c < point.size(); ++c)
    if (point[c] < 0) gradient[c] = -gradient[c];
  return length + std::min(beyond.maxCoeff(), 0.0) - radius;
}

}  // namespace deform
