/// What contact does to the motion of one node: no motion into the body, Coulomb's friction.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "deform/model/reduction.h"
#include "deform/types.h"

namespace deform {

/// How a node moves where constraints hold or tie some of its components: an impulse J on it
/// changes the unknowns q by Rᵀ J and its own velocity by R Rᵀ J, with R = ∂r/∂q of the node, all
/// per mass. R is the identity for a node that nothing holds.
class Mobility {
 public:
  /// Which nodes constraints touch; what is behind them counts as held. `map` must live as long.
  Mobility(const ReductionMap& map, Index nodes);

  /// Whether nothing holds a node; whether nothing of it is free.
  [[nodiscard]] bool is_free(Index node) const { return kind(node) == kFree; }
  [[nodiscard]] bool is_held(Index node) const { return kind(node) == kHeld; }
  /// n·R Rᵀ n: 1 for a node that nothing holds, 0 where it cannot move along n.
  [[nodiscard]] double along(Index node, const Vec3& n) const {
    return kind(node) == kFree ? 1 : kind(node) == kHeld ? 0 : n.dot(of(node).matrix * n);
  }
  /// Whether a body with that normal can push a node anywhere.
  [[nodiscard]] bool is_movable(Index node, const Vec3& n) const { return along(node, n) > kLeast; }
  /// The part of a motion (or of a force) along which a node can slide on a body with that normal:
  /// in the range Q of R, and across n, (Q − m mᵀ/m²) motion with m = Q n. All that is across n for
  /// a node that nothing holds.
  [[nodiscard]] Vec3 sliding(Index node, const Vec3& n, const Vec3& motion) const;
  /// R Rᵀ J.
  [[nodiscard]] Vec3 response(Index node, const Vec3& impulse) const {
    return kind(node) == kFree ? impulse : Vec3(of(node).matrix * impulse);
  }
  /// The largest eigenvalue of R Rᵀ, or 1 if that is more.
  [[nodiscard]] double bound(Index node) const { return kind(node) == kFree ? 1 : of(node).bound; }
  /// R q: a field's (N × 3) values at the unknowns that a node follows, as the node feels them.
  [[nodiscard]] Vec3 motion(Index node, const NodeVectors& field) const;
  /// Adds Rᵀ J to a field (N × 3) at the unknowns that a node follows. What is tied to these is
  /// left to `follow`.
  void add(Index node, const Vec3& impulse, NodeVectors& field) const;
  [[nodiscard]] const ReductionMap& map() const { return *map_; }
  [[nodiscard]] bool has_ties() const { return !map_->ties().empty(); }

 private:
  static constexpr std::int32_t kFree = -1, kHeld = -2;
  /// Square of the sine of the angle between a body's surface and the directions that a node is
  /// free in, below which it passes: pushing it out would take it far along the surface.
  static constexpr double kLeast = 1e-4;
  struct Partly {
    std::array<ReductionMap::Row, 3> rows;
    Eigen::Matrix3d matrix;  // R Rᵀ
    Eigen::Matrix3d range;   // Q: projects on the range of R
    double bound = 1;
  };
  [[nodiscard]] std::int32_t kind(Index node) const {
    return kind_[static_cast<std::size_t>(node)];
  }
  [[nodiscard]] const Partly& of(Index node) const {
    return partly_[static_cast<std::size_t>(kind(node))];
  }

  const ReductionMap* map_;
  std::vector<std::int32_t> kind_;  // of each node: kFree, kHeld, or its place in …
  std::vector<Partly> partly_;
};

/// A node's contact with one body, and how it has changed the node's motion so far. Motion is
/// velocity [m/s], or displacement within a step [m]; impulses are per mass, in the same unit.
struct Grip {
  Vec3 normal = Vec3::UnitZ();
  double friction = 0;          ///< Coulomb's coefficient
  double least = 0;             ///< of the motion along the normal
  Vec3 carried = Vec3::Zero();  ///< the body's own motion: friction is about what is beside it
  double normal_impulse = 0;    ///< along the normal, never negative
  Vec3 friction_impulse = Vec3::Zero();
};

/// Changes impulses until the motion along each normal is at least what it must be, none pulls, and
/// what slides is resisted by friction × push, but not driven back: for one contact at once, for
/// several by turns (projected Gauss–Seidel: Jourdan, Alart & Jean 1998). Friction acts only where
/// the node can slide by itself; along what constraints prescribe it would push it along the
/// normal. Returns the change of the sum of impulses; `motion` becomes what they make of it.
[[nodiscard]] Vec3 settle_motion(const Mobility& mobility, Index node, std::span<Grip> grips,
                                 Vec3& motion);

}  // namespace deform
