/// Contact of a surface's nodes with the colliders of its scene.
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "deform/export.h"
#include "deform/model/reduction.h"
#include "deform/solve/contact_report.h"
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

/// A step, or a part of one, that takes nodes from where they were (N × 3) [m] at a time [s] to
/// where they are at another one.
struct NodePaths {
  double begin = 0;
  const NodeVectors& from;
  double end = 0;
  const NodeVectors& to;
};

class Mobility;

/// Keeps nodes outside of bodies. A step that ends with a node inside is amended: the node goes to
/// the nearest point of the body, and what it moved along the body's surface within the step is
/// shortened by at most friction × how far it was pushed. That is Coulomb's law: what the body's
/// push changes of the motion along the normal, friction changes by at most so many times that of
/// the motion across. For the velocity the same law holds by itself, however a method makes
/// positions of velocities. Motion is that beside the body's own, where that moves. A node that has
/// come with some speed along the normal leaves with its collider's coefficient of restitution
/// times that (Newton's law; Moreau's rule: what rests has come with none).
///
/// A node whose path through the step, as the body sees it, leads into a body on another side than
/// the one where it is nearest to the surface in the end, or right through a part of it, is stopped
/// where it came in.
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
  /// at `before`, `step` seconds earlier, on its surface, with friction; their velocities become
  /// those after an impact. What constraints hold of a node stays. Returns the impulses on
  /// velocities, by collider, nodes ascending.
  std::vector<ContactImpulse> resolve(const State& before, double step, State& after) const;
  /// The nodes whose gap to a collider is less than `within` [m] at the paths' end; each collider
  /// by itself, nodes ascending.
  void find(const NodePaths& paths, double within, std::vector<NodeContact>& found) const;
  /// Makes velocities at the end of a step of so many seconds, which began with `before`, those
  /// that contact leaves: a node does not move into a collider, nor away from it by more than a
  /// push and restitution let it, and what slides is slowed by friction × push. `impulses`: what
  /// the velocities know of it already; made what they know in the end.
  void settle(const State& before, double step, std::vector<ContactImpulse>& impulses,
              State& after) const;
  /// For one body: where nodes that are at r (N × 3) at a time were, or will be, at another one, if
  /// they moved with it [m]; false where it does not move.
  [[nodiscard]] bool carry(std::size_t body, double from, double to, const NodeVectors& r,
                           NodeVectors& carried) const;
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
