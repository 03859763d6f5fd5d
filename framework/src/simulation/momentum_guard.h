/// Looks out for runs whose momentum is not what the forces put in.
#pragma once

#include "deform/record/frame.h"
#include "deform/solve/integrator.h"

#include "simulation/guarded_steps.h"

namespace deform {

/// Compares the change of momentum over the guarded steps in a row with the impulse of all forces,
/// and warns once where they differ by more than a tenth of the impulses' sizes. A step's impulse
/// is only known to lie between those of the forces at its beginning and at its end, component by
/// component: methods differ in where they take forces. Nothing is known where constraints or
/// colliders push (their impulses are the method's own), of statics, and of terms whose energy is
/// not the same wherever the surface is.
class MomentumGuard {
 public:
  MomentumGuard(const System& system, const Named<Integrator>& integrator);

  /// Whether the step that begins with this number of steps done is looked at: `begin` and `end`
  /// are called then, and `at_break` in between.
  [[nodiscard]] bool watches(long steps) const;
  void begin(const Frame& frame);
  void at_break(const Frame& frame);
  void end(const Frame& frame);
  /// Looks no more.
  void stop() { is_known_ = false; }

 private:
  /// Of all forces [N].
  struct Sum {
    Vec3 vector = Vec3::Zero();
    double sizes = 0;  // of each node's
  };
  [[nodiscard]] static Sum sum(const Frame& frame, NodeVectors loads);
  [[nodiscard]] static bool has_internal_net_force(const Frame& frame);
  void add_part(const Frame& frame, double length);
  void warn(const Frame& frame, const Vec3& gained, const Vec3& impulse);

  bool is_known_;
  bool is_checked_ = false;  // whether the terms' net force has been looked at
  bool warned_ = false;
  double counted_ = 0;  // of the step under way, up to breaks [s]
  long last_ = -1;      // step that was looked at last
  long in_a_row_ = 0;
  Vec3 first_ = Vec3::Zero();  // momentum where the row began [kg·m/s]
  double largest_ = 0;         // sum of the sizes of nodes' momenta, so far
  Vec3 least_ = Vec3::Zero();  // impulse since then, at least and at most [N·s]
  Vec3 most_ = Vec3::Zero();   //
  double sizes_ = 0;           // sum of the sizes of all impulses
  Sum force_;                  // where the last part ended
};

}  // namespace deform
