/// Constraints: they write what they reserved, and depend on time alone.
#include <algorithm>
#include <cmath>
#include <random>
#include <string>

#include <fmt/format.h>

#include "check/bitwise.h"
#include "check/contracts.h"

namespace deform {
namespace {

/// Positions that no constraint would choose, to see which are written.
constexpr double kElsewhere = 1e3;

bool is_finite_tie(const Tie& tie) {
  return std::isfinite(tie.offset) && std::ranges::all_of(tie.parts, [](const Tie::Part& p) {
           return std::isfinite(p.coefficient);
         });
}

/// f·(T q) = (Tᵀf)·q for a random f and q.
void check_transpose(const ReductionMap& map, Checks& checks) {
  std::mt19937 random(54321);
  std::uniform_real_distribution<double> uniform(-1, 1);
  const Index nodes = map.reduction().nodes();
  const NodeVectors f = NodeVectors::NullaryExpr(nodes, 3, [&] { return uniform(random); });
  NodeVectors q = NodeVectors::NullaryExpr(nodes, 3, [&] { return uniform(random); });
  for (int c = 0; c < 3; ++c)
    for (Index a = 0; a < nodes; ++a)
      if (!map.reduction().free(a, c)) q(a, c) = 0;
  NodeVectors change = q, reduced = f;
  map.complete_changes(change);
  map.transpose(reduced);
  const double expected = f.cwiseProduct(change).sum(), found = reduced.cwiseProduct(q).sum();
  checks.below("forces on tied components do the work that they should",
               std::abs(expected - found) / (f.norm() * change.norm() + 1e-300), 1e-12);
}

void check_prescriptions(const Made<Constraint>& made, Checks& checks) {
  const Index nodes = made.surface->nodes();
  Reduction reduction(nodes);
  made.object->reduce(reduction);
  const auto prescribed_at = [&](double time) {
    NodeVectors r = NodeVectors::Constant(nodes, 3, kElsewhere);
    made.object->prescribe(time, r);
    return r;
  };
  check_breaks(*made.object, checks);
  const std::array<double, 4> times{0, 0.37, 5, 0.37};
  std::array<NodeVectors, 4> at;
  for (std::size_t i = 0; i < times.size(); ++i) at[i] = prescribed_at(times[i]);
  checks.holds("depends on time alone", at[1] == at[3], "asked again, it gave other positions");

  bool is_kept = true, is_written = true;
  std::string not_finite;
  Index held = 0;
  for (const NodeVectors& r : at)
    for (Index a = 0; a < nodes; ++a)
      for (int c = 0; c < 3; ++c) {
        const bool is_reserved = reduction.prescribed(a, c);
        held += is_reserved ? 1 : 0;
        is_kept = is_kept && (is_reserved || r(a, c) == kElsewhere);
        is_written = is_written && (!is_reserved || r(a, c) != kElsewhere);
        if (not_finite.empty() && !std::isfinite(r(a, c)))
          not_finite = fmt::format("{} of node {} is {}", "xyz"[c], a, r(a, c));
      }
  checks.holds("writes no component that it did not reserve", is_kept, "it wrote another");
  checks.holds("writes every component that it reserved", is_written, "one was left as it was");
  checks.holds("gives finite positions", not_finite.empty(), not_finite);
  const ReductionMap map(reduction);  // which throws for ties in circles
  checks.holds("its ties are finite", std::ranges::all_of(map.ties(), is_finite_tie),
               "a coefficient or an offset is not");
  check_transpose(map, checks);
  checks.report("components tied", std::to_string(map.ties().size()));
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
  check_run(subject, checks, [&](const Terrain& terrain) {
    const Made<Constraint> made = subject.make<Constraint>(terrain);
    Reduction reduction(made.surface->nodes());
    made.object->reduce(reduction);
    return !reduction.ties_mix_components();  // the check's integrator solves x, y, z one by one
  });
}

}  // namespace deform
