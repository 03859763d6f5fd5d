/// All constraints of a model together: r = T q + b.
#pragma once

#include <memory>

#include "deform/export.h"
#include "deform/model/reduction.h"
#include "deform/solve/model_parts.h"
#include "deform/solve/state.h"
#include "deform/types.h"

namespace deform {

/// Which components are free, where the others go, and what that means for forces.
class DEFORM_API ConstraintSet {
 public:
  explicit ConstraintSet(const ModelParts& parts);

  [[nodiscard]] const Reduction& reduction() const { return map_.reduction(); }
  [[nodiscard]] const ReductionMap& map() const { return map_; }

  /// Writes the prescribed components [m] at a time, and those that are tied to others; leaves
  /// these alone.
  void prescribe(double time, NodeVectors& r) const;
  /// Writes the velocities of prescribed components [m/s] at a time, and of those tied to others,
  /// by differences of positions within `reach` [s] of it: before it where that is positive, after
  /// it where negative. The two differ where a path has a corner; a step's length with its sign
  /// looks at that step alone, and is right in any unit of time.
  void prescribe_velocity(double time, double reach, NodeVectors& v) const;
  /// Puts `after`, whose time is `step` seconds later than `before`'s, on the constraints:
  /// prescribed components get their positions and the velocity that led there. What an explicit
  /// step ends with.
  void constrain(const NodeVectors& before, double step, State& after) const;
  /// Writes the components of positions, or of velocities, that are tied to others.
  void follow_ties(NodeVectors& r) const { map_.complete_positions(r); }
  void follow_ties_of_velocity(NodeVectors& v) const { map_.complete_changes(v); }
  /// Tᵀf in place (N × 3): what acts on free components, that on tied ones included.
  void reduce_force(NodeVectors& f) const { map_.transpose(f); }

 private:
  [[noreturn]] void throw_not_finite(double time, Index node) const;

  std::vector<Named<Constraint>> constraints_;
  ReductionMap map_;
  Index rows_;
};

}  // namespace deform
