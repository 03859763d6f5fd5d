#include "deform/solve/force_jacobian.h"

#include <algorithm>
#include <cstdint>

#include "deform/solve/system.h"

#include "not_finite.h"
#include "solve/assembly/all_forces.h"
#include "solve/matrix/coloured_jacobian.h"
#include "solve/stopwatch.h"
#include "solve/system_parts.h"

namespace deform {
namespace {

/// The corners of a face depend on each other.
template <class Add>
void add_faces(const Faces& faces, const Add& add) {
  for (std::size_t f = 0; f + 1 < faces.begin.size(); ++f)
    for (std::int32_t i = faces.begin[f]; i < faces.begin[f + 1]; ++i)
      for (std::int32_t j = faces.begin[f]; j < faces.begin[f + 1]; ++j)
        add(faces.nodes[static_cast<std::size_t>(i)], faces.nodes[static_cast<std::size_t>(j)]);
}

/// Node by node, those whose positions its force depends on.
std::vector<std::vector<std::int32_t>> dependence(ModelTerms& terms) {
  std::vector<std::vector<std::int32_t>> on(static_cast<std::size_t>(terms.rows()));
  const auto add = [&](Index a, Index b) {
    on[static_cast<std::size_t>(a)].push_back(static_cast<std::int32_t>(b));
  };
  const auto add_both = [&](Index a, Index b) { add(a, b), add(b, a); };
  for (const SetTerms& set : terms.sets()) set.assembler.visit_dependence(add);
  for (const TupleAssembler& t : terms.tuples()) t.visit_pattern(add);
  terms.external().visit_pattern(add_both);
  if (terms.external().needs_neighbours()) add_faces(terms.parts().surface->faces(), add);
  for (std::size_t a = 0; a < on.size(); ++a) {
    on[a].push_back(static_cast<std::int32_t>(a));
    std::ranges::sort(on[a]);
    on[a].erase(std::unique(on[a].begin(), on[a].end()), on[a].end());
  }
  return on;
}

}  // namespace

struct ForceJacobian::Impl {
  Impl(SystemParts& of, const std::vector<Freedom>& held)
      : parts(&of),
        jacobian(of.constraints.map(), dependence(of.assembly.terms), held, of.solvers) {}
  SystemParts* parts;
  ColouredJacobian jacobian;
  State moved;
  NodeVectors force;
};

ForceJacobian::ForceJacobian(const System& system, const std::vector<Freedom>& held)
    : impl_(std::make_unique<Impl>(SystemParts::of(system), held)) {}
ForceJacobian::~ForceJacobian() = default;

void ForceJacobian::evaluate(const State& state, double rate, const StepStrains* strains) {
  Impl& i = *impl_;
  const Stopwatch watch(&StepTimes::assembly, "Jacobian");
  i.moved = state;
  i.jacobian.differentiate(state.r, [&](const NodeVectors& r) -> const NodeVectors& {
    i.moved.r = r;
    if (rate != 0) i.moved.v = state.v + rate * (r - state.r);
    i.parts->evaluator.force(i.moved, i.force, strains);
    return i.force;
  });
}

std::string ForceJacobian::factor(const NodeValues& d) {
  Impl& i = *impl_;
  i.parts->meter.require_going_on();
  const Stopwatch watch(&StepTimes::factorisation, "factorisation");
  std::string reason = i.jacobian.factor(d);
  i.parts->meter.choose(WorkMeter::Matrix::jacobian, i.jacobian.choice());
  return reason;
}

std::string ForceJacobian::solve(const NodeVectors& b, NodeVectors& x) {
  Impl& i = *impl_;
  i.parts->meter.require_going_on();
  require_finite(b, "the right-hand side", "the integrator", "");
  const Stopwatch watch(&StepTimes::solve, "solve");
  return i.jacobian.solve(b, x);
}

}  // namespace deform
