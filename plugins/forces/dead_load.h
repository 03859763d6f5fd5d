/// Loads that keep their direction and size whatever the surface does.
#pragma once

#include <utility>

#include <deform/model/force_field.h>

namespace deform {

/// f_a = factor(t) F s_a, with a share s_a of each node: of 1 for a total force F [N], in metres
/// for a force per length F [N/m].
class DeadLoad : public ForceField {
 public:
  /// `shares`: (N).
  DeadLoad(const Vec3& force, TimeProfile time, NodeValues shares)
      : force_(force), time_(std::move(time)), shares_(std::move(shares)) {}

  [[nodiscard]] double next_break(double after) const override { return time_.next_break(after); }
  [[nodiscard]] ForceTraits traits() const override { return {.potential = true}; }

  void add_force(const NodeBlock& nodes, Vectors force) const override {
    const Vec3 now = time_(nodes.time) * force_;
    for (Index i = 0; i < nodes.size; ++i) force.add(i, shares_[nodes.first + i] * now);
  }
  void add_potential(const NodeBlock& nodes, Values energy) const override {
    const Vec3 now = time_(nodes.time) * force_;
    for (Index i = 0; i < nodes.size; ++i)
      energy[i] -= shares_[nodes.first + i] * now.dot(nodes.r[i]);
  }

 private:
  Vec3 force_;
  TimeProfile time_;
  NodeValues shares_;
};

}  // namespace deform
