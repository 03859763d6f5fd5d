/// Constraints: they write what they reserved, and depend on time alone.
#include <cmath>

#include "check/bitwise.h"
#include "check/contracts.h"

namespace deform {
namespace {

/// Positions that no constraint would choose, to see which are written.
constexpr double kElsewhere = 1e3;

void check_prescriptions(const Made<Constraint>& made, Checks& checks) {
  const Index nodes = made.surface->nodes();
  Reduction reduction(nodes);
  made.object->reduce(reduction);
  const auto prescribed_at = [&](double time) {
    NodeVectors r = NodeVectors::Constant(nodes, 3, kElsewhere);
    made.object->prescribe(time, r);
    return r;
  };
  const std::array<double, 4> times{0, 0.37, 5, 0.37};
  std::array<NodeVectors, 4> at;
  for (std::size_t i = 0; i < times.size(); ++i) at[i] = prescribed_at(times[i]);
  checks.holds("depends on time alone", at[1] == at[3], "asked again, it gave other positions");

  bool is_kept = true, is_written = true, is_finite = true;
  Index held = 0;
  for (const NodeVectors& r : at)
    for (Index a = 0; a < nodes; ++a)
      for (int c = 0; c < 3; ++c) {
        const bool is_reserved = reduction.prescribed(a, c);
        held += is_reserved ? 1 : 0;
        is_kept = is_kept && (is_reserved || r(a, c) == kElsewhere);
        is_written = is_written && (!is_reserved || r(a, c) != kElsewhere);
        is_finite = is_finite && std::isfinite(r(a, c));
      }
  checks.holds("writes no component that it did not reserve", is_kept, "it wrote another");
  checks.holds("writes every component that it reserved", is_written, "one was left as it was");
  checks.holds("gives finite positions", is_finite, "one is not finite");
  checks.report("components held", std::to_string(held / static_cast<Index>(times.size())));
  NodeVectors moved = at[0] - made.surface->initial();
  for (int c = 0; c < 3; ++c)
    for (Index a = 0; a < nodes; ++a)
      if (!reduction.prescribed(a, c)) moved(a, c) = 0;
  checks.report("largest jump from the initial positions at time 0",
                moved.size() == 0 ? 0 : moved.cwiseAbs().maxCoeff(), "m");
}

}  // namespace

void check_constraint_contract(const Subject& subject, Checks& checks) {
  for (const Terrain& terrain : terrains(9, 7)) {
    checks.at(terrain.name);
    checks.runs("prescribes positions",
                [&] { check_prescriptions(subject.make<Constraint>(terrain), checks); });
  }
  check_run(subject, checks);
}

}  // namespace deform
