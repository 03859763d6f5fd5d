/// What colliders do to a surface within a step.
#pragma once

#include <cstddef>
#include <vector>

#include "deform/export.h"
#include "deform/plugin/plugin.h"
#include "deform/types.h"

namespace deform {

/// Impulse of a collider on a node within a step, per mass [m/s].
struct ContactImpulse {
  Index node = 0;
  std::size_t body = 0;  ///< its number among the scene's colliders
  Vec3 normal = Vec3::UnitZ();
  double normal_impulse = 0;             ///< along the normal
  Vec3 friction_impulse = Vec3::Zero();  ///< across it
};

/// The sums over a step of the scene. Impulses are those that balance momentum: what a node's
/// momentum changes by, less the impulse of all other forces.
class DEFORM_API ContactReport {
 public:
  /// Adds a step, or a part of it, of so many seconds, between whose ends velocities (N × 3) change
  /// so; mass (N) [kg].
  void add(const NodeValues& mass, const std::vector<ContactImpulse>& impulses,
           const NodeVectors& v_begin, const NodeVectors& v_end, double length);
  /// Nothing was added.
  void clear();

  /// What the sums are of [s]; 0: nothing is known.
  [[nodiscard]] double time() const { return time_; }
  /// Whether something touched; else there are no impulses.
  [[nodiscard]] bool any() const { return any_; }
  /// (N × 3) [N·s]
  [[nodiscard]] const NodeVectors& normal_impulse() const { return normal_; }
  [[nodiscard]] const NodeVectors& friction_impulse() const { return friction_; }
  /// Their means over the time on the first so many rows, a surface's nodes (N × 3) [N]; not a
  /// number where nothing is known.
  [[nodiscard]] NodeVectors normal_force(Index nodes) const { return mean(normal_, nodes); }
  [[nodiscard]] NodeVectors friction_force(Index nodes) const { return mean(friction_, nodes); }
  /// Done on the surface [J]: impulses times the mean of the velocities before and after, which is
  /// their share in the change of kinetic energy.
  [[nodiscard]] double normal_work() const { return normal_work_; }
  [[nodiscard]] double friction_work() const { return friction_work_; }

  void save(Memory& memory) const;
  /// Of a system with so many rows. Throws InputError when it is none.
  void load(const Memory& memory, Index rows);

 private:
  [[nodiscard]] NodeVectors mean(const NodeVectors& impulse, Index nodes) const;

  double time_ = 0;
  bool any_ = false;
  NodeVectors normal_, friction_;
  double normal_work_ = 0, friction_work_ = 0;
};

}  // namespace deform
