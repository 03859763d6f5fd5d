/// Contact of a surface's nodes with the colliders of its scene.
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "deform/export.h"
#include "deform/model/reduction.h"
#include "deform/solve/model_parts.h"
#include "deform/solve/state.h"
#include "deform/types.h"

namespace deform {

/// A node near a collider that can push it: no constraint holds it along the normal.
struct NodeContact {
  Index node = 0;
  std::size_t body = 0;         ///< its number among the scene's colliders
  double gap = 0;               ///< distance less the collider's thickness; negative inside [m]
  Vec3 normal = Vec3::UnitZ();  ///< along which the distance grows
  double friction = 0;          ///< Coulomb's coefficient
  /// n·∂r/∂q (∂r/∂q)ᵀ n with the unknowns q that the node follows: 1 where nothing holds it.
  double mobility = 1;
  /// Whether the node has come through the body, or in on another side than the nearest: the gap is
  /// then to the tangent plane where it came in.
  bool crossed = false;
};

/// Impulse of a collider on a node within a step, per mass [m/s].
struct ContactImpulse {
  Index node = 0;
  std::size_t body = 0;  ///< its number among the scene's colliders
  Vec3 normal = Vec3::UnitZ();
  double normal_impulse = 0;             ///< along the normal
  Vec3 friction_impulse = Vec3::Zero();  ///< across it
};

class Mobility;

/// Keeps nodes outside of bodies. A step that ends with a node inside is amended: the node goes to
/// the nearest point of the body, and what it moved along the body's surface within the step is
/// shortened by at most friction × how far it was pushed. That is Coulomb's law: what the body's
/// push changes of the motion along the normal, friction changes by at most so many times that of
/// the motion across. For the velocity the same law holds by itself, however a method makes
/// positions of velocities: contact is inelastic.
///
/// A node whose path through the step leads into a body on another side than the one where it is
/// nearest to the surface in the end, or right through a part of it, is stopped where it came in.
///
/// Nodes move as far as constraints leave them free; those that are held along a body's normal
/// pass: they are where the scene wants them.
class DEFORM_API ColliderContact {
 public:
  /// Of so many nodes; `map`, which may know of more unknowns, must live as long.
  ColliderContact(std::vector<Body> bodies, Index nodes, const ReductionMap& map);
  ~ColliderContact();
  ColliderContact(const ColliderContact&) = delete;
  ColliderContact& operator=(const ColliderContact&) = delete;

  [[nodiscard]] std::size_t bodies() const;
  /// Puts nodes that `after` has inside of a collider, or on the other side of one than they were
  /// at `before` (N × 3), `step` seconds earlier, on its surface, with friction; their velocities
  /// become those after an inelastic impact. What constraints hold of a node stays. Returns which
  /// nodes, ascending.
  std::vector<Index> resolve(const NodeVectors& before, double step, State& after) const;
  /// The nodes whose gap to a collider is less than `within` [m] at a time, were they at `r`,
  /// having come from `from` (both N × 3); each collider by itself, nodes ascending.
  void find(double time, const NodeVectors& from, const NodeVectors& r, double within,
            std::vector<NodeContact>& found) const;
  /// Makes velocities at a state, which a step of so many seconds ends with, those that contact
  /// leaves: a node does not move into a collider, nor away from it by a push alone, and what
  /// slides is slowed by friction × push. `impulses`: what the velocities know of it.
  void settle(double step, const std::vector<ContactImpulse>& impulses, State& state) const;
  /// (M) Distance of points (M × 3) to the nearest collider at a time, negative inside [m];
  /// infinite where there is none.
  [[nodiscard]] NodeValues clearance(double time, const NodeVectors& points) const;
  /// Throws InputError when a node that a collider can push begins inside of it by more than
  /// `slack` [m].
  void require_outside(const NodeVectors& r, double slack) const;

  /// How nodes are free to move; for contact's laws.
  [[nodiscard]] const Mobility& mobility() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace deform
