#include "deform/solve/constraint_set.h"

#include <cmath>
#include <string>

#include "not_finite.h"
#include "plugin/guard.h"

namespace deform {
namespace {

/// Prescribed velocities are differences of positions over this part of a step: shorter ones lose
/// digits, longer ones the order of methods up to the fourth.
constexpr double kPartOfReach = 1e-3;

ReductionMap map_of(const ModelParts& parts) {
  const Index nodes = parts.surface->nodes();
  Reduction reduction(nodes + std::ssize(parts.scalars));
  for (Index a = nodes; a < reduction.nodes(); ++a)  // a scalar has but one component
    for (const int c : {1, 2}) reduction.prescribe(a, c);
  for (const auto& c : parts.constraints)
    guarded(c.origin, "saying what it holds", [&] { c.object->reduce(reduction); });
  return ReductionMap(reduction);
}

}  // namespace

ConstraintSet::ConstraintSet(const ModelParts& parts)
    : constraints_(parts.constraints), map_(map_of(parts)), rows_(reduction().nodes()) {}

void ConstraintSet::prescribe(double time, NodeVectors& r) const {
  if (constraints_.empty()) return;
  for (const auto& c : constraints_) {
    guarded(c.origin, "prescribing positions", [&] { c.object->prescribe(time, r); });
    if (r.rows() != rows_)
      throw PluginFailure("plugin " + c.origin + " made " + std::to_string(r.rows()) +
                          " positions of the " + std::to_string(rows_) + " that it was given");
  }
  for (int c = 0; c < 3; ++c)
    for (Index a = 0; a < r.rows(); ++a)
      if (!std::isfinite(r(a, c)) && reduction().prescribed(a, c)) throw_not_finite(time, a);
  map_.complete_positions(r);
}

void ConstraintSet::throw_not_finite(double time, Index node) const {
  for (const auto& c : constraints_) {
    NodeVectors alone = NodeVectors::Zero(rows_, 3);  // what is in r may be another's
    guarded(c.origin, "prescribing positions", [&] { c.object->prescribe(time, alone); });
    require_finite(alone, "a prescribed position", c.origin, c.name);
  }
  throw NotFinite("a prescribed position is not finite", node, "constraints");
}

void ConstraintSet::prescribe_velocity(double time, double reach, NodeVectors& v) const {
  if (constraints_.empty()) return;
  // Constraints give positions alone. The parabola through three of them, of which the farthest is
  // two differences away, is wrong by a third of the difference squared times r⃛.
  double difference = time - (time - kPartOfReach * reach);  // of times that are numbers
  if (difference == 0) difference = reach;
  NodeVectors now = NodeVectors::Zero(rows_, 3), near = now, far = now;
  prescribe(time, now);
  prescribe(time - difference, near);
  prescribe(time - 2 * difference, far);
  for (int c = 0; c < 3; ++c)
    for (Index a = 0; a < v.rows(); ++a)
      if (reduction().prescribed(a, c))
        v(a, c) = (4 * (now(a, c) - near(a, c)) - (now(a, c) - far(a, c))) / (2 * difference);
  follow_ties_of_velocity(v);
}

void ConstraintSet::constrain(const NodeVectors& before, double step, State& after) const {
  prescribe(after.time, after.r);
  for (int c = 0; c < 3; ++c)
    for (Index a = 0; a < before.rows(); ++a)
      if (!reduction().free(a, c)) after.v(a, c) = (after.r(a, c) - before(a, c)) / step;
}

}  // namespace deform
