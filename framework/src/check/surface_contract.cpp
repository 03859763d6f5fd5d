/// Surfaces and shapes. That sizes and numbers fit together is checked whenever a surface is made.
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "deform/error.h"
#include "deform/geometry/characteristic_length.h"
#include "deform/model/reduction.h"
#include "deform/surface/shape.h"

#include "check/bitwise.h"
#include "check/contracts.h"

namespace deform {
namespace {

/// Largest error of the operators at the samples, for positions (f(a1, a2), 0, 0).
template <class Function>
double operator_error(const Surface& surface, const SampleSet& samples, const Function& f,
                      Derivative d, double expected) {
  const auto& a = surface.parameters();
  NodeVectors v = NodeVectors::Zero(a.rows(), 3);
  for (Index i = 0; i < a.rows(); ++i) v(i, 0) = f(a(i, 0), a(i, 1));
  const NodeVectors result = samples.apply(d, v);
  double worst = 0;
  for (Index s = 0; s < samples.size(); ++s) {
    if (samples.computable(d, s)) worst = std::max(worst, std::abs(result(s, 0) - expected));
  }
  return worst;
}

/// Charts of single samples are orthonormal at rest.
void check_charts(const SampleSet& samples, const NodeVectors& rest, SampleRole role,
                  Checks& checks) {
  Geometry geometry(samples);
  geometry.compute(samples, rest, Geometry::Detail::metric);
  double worst = 0;
  for (const Pair ij : kPairs)
    for (const double G : geometry.all().G(ij))
      worst = std::max(worst, std::abs(G - (ij == Pair::p12 ? 0 : 1)));
  if (role == SampleRole::membrane)
    checks.below("operators: the metric at rest is 1", worst, 1e-9);
  else
    checks.report("operators: what the metric at rest differs from 1 by, for bending", worst, "");
}

void check_operators(const Surface& surface, SampleRole role, Checks& checks) {
  const SampleSet& samples = surface.samples(role);
  const auto one = [](double, double) { return 1.0; };
  const auto a1 = [](double x, double) { return x; };
  const auto a2 = [](double, double y) { return y; };
  checks.below("operators: derivatives of a constant are 0",
               std::max({operator_error(surface, samples, one, Derivative::d1, 0),
                         operator_error(surface, samples, one, Derivative::d11, 0),
                         operator_error(surface, samples, one, Derivative::d12, 0),
                         operator_error(surface, samples, one, Derivative::d22, 0)}),
               1e-8);
  if (!surface.has_chart()) return check_charts(samples, surface.rest(), role, checks);
  if (surface.period() != Vec2::Zero()) return;  // a1 and a2 jump where sides are joined
  checks.below("operators: first derivatives of a1 and a2 are exact",
               std::max({operator_error(surface, samples, a1, Derivative::d1, 1),
                         operator_error(surface, samples, a1, Derivative::d2, 0),
                         operator_error(surface, samples, a2, Derivative::d1, 0),
                         operator_error(surface, samples, a2, Derivative::d2, 1)}),
               1e-8);
  const auto product = [](double x, double y) { return x * y; };
  const auto square = [](double x, double) { return 0.5 * x * x; };
  checks.report("operators: error in the second derivatives of quadratics",
                std::max(operator_error(surface, samples, product, Derivative::d12, 1),
                         operator_error(surface, samples, square, Derivative::d11, 1)),
                "1/m");
}

double sum(const std::vector<EdgeNode::Entry>& row, const auto& value) {
  double result = 0;
  for (const EdgeNode::Entry& entry : row) result += entry.coefficient * value(entry.node);
  return result;
}

/// At an edge (a1, a2) changes by unit vectors, inwards the one to the left of that along it.
void check_edges(const Surface& surface, Checks& checks) {
  double of_constant = 0, of_parameters = 0;
  for (const std::string& name : surface.boundary_names())
    for (const EdgeNode& at : surface.edge(name)) {
      const auto derivative = [&](const std::vector<EdgeNode::Entry>& row) {
        of_constant = std::max(of_constant, std::abs(sum(row, [](Index) { return 1.0; })));
        return Vec2(sum(row, [&](Index node) { return surface.parameters()(node, 0); }),
                    sum(row, [&](Index node) { return surface.parameters()(node, 1); }));
      };
      const Vec2 inwards = derivative(at.inwards), along = derivative(at.along);
      of_parameters = std::max({of_parameters, std::abs(along.norm() - 1),
                                (inwards - Vec2(-along.y(), along.x())).lpNorm<Eigen::Infinity>()});
    }
  checks.below("edges: derivatives of a constant are 0", of_constant, 1e-8);
  if (surface.period() != Vec2::Zero()) return;  // a1 and a2 jump where sides are joined
  checks.below("edges: along and inwards are unit vectors, inwards to the left", of_parameters,
               1e-8);
}

/// The node that a clamp solves a row for: the nearest one that is not the side's.
Index solved_for(const EdgeNode& edge, const std::vector<Index>& side) {
  const EdgeNode::Entry* best = nullptr;
  for (const EdgeNode::Entry& entry : edge.inwards)
    if (!std::ranges::binary_search(side, entry.node) &&
        (best == nullptr || std::abs(entry.coefficient) > std::abs(best->coefficient)))
      best = &entry;
  if (best == nullptr || best->coefficient == 0)
    throw InputError(fmt::format("the row of node {} names no node beside the side's", edge.node));
  return best->node;
}

/// The derivatives across a side can be held, each by a node of its own.
void check_side(const Surface& surface, const std::string& name) {
  const std::vector<Index> side = surface.boundary(name);
  Reduction reduction(surface.nodes());
  for (const Index node : side) reduction.prescribe(node, 0);
  for (const EdgeNode& edge : surface.edge(name)) {
    if (std::ranges::find(edge.inwards, edge.node, &EdgeNode::Entry::node) == edge.inwards.end())
      throw InputError(fmt::format("the row of node {} does not name that node", edge.node));
    Tie tie{{solved_for(edge, side), 0}, {}, 0};
    if (!reduction.free(tie.freedom.node, 0))
      throw InputError(fmt::format("the row of node {} is solved for node {}, as another one is",
                                   edge.node, tie.freedom.node));
    for (const EdgeNode::Entry& entry : edge.inwards)
      if (entry.node != tie.freedom.node) tie.parts.push_back({{entry.node, 0}, 1});
    reduction.tie(tie);
  }
  (void)reduction.ties();  // throws for circles
}

void check_sides(const Surface& surface, Checks& checks) {
  for (const std::string& name : surface.boundary_names())
    checks.runs("edges: rows across can be held (see EdgeNode)", [&] {
      try {
        check_side(surface, name);
      } catch (const InputError& e) {
        throw InputError(fmt::format("edge(\"{}\"): {}", name, e.what()));
      }
    });
}

void check_areas(const Surface& surface, Checks& checks) {
  const double nodes = surface.areas().sum();
  for (const SampleRole role : {SampleRole::membrane, SampleRole::bending}) {
    double samples = 0;
    for (const double weight : surface.samples(role).weights()) samples += weight;
    checks.below("areas of samples and of nodes have one sum, relative",
                 std::abs(samples - nodes) / nodes, 1e-9);
  }
}

}  // namespace

void check_surface_contract(const Subject& subject, Checks& checks) {
  const Terrain anywhere = terrains(9, 7).front();
  checks.runs("describes its nodes", [&] {
    const auto surface = subject.make<Surface>(anywhere).object;
    for (const SampleRole role : {SampleRole::membrane, SampleRole::bending})
      check_operators(*surface, role, checks);
    check_edges(*surface, checks);
    check_sides(*surface, checks);
    check_areas(*surface, checks);
    checks.report("nodes", std::to_string(surface->nodes()));
    const auto again = subject.make<Surface>(anywhere).object;
    checks.holds("made again, it is the same", surface->initial() == again->initial(),
                 "initial positions differ");
  });
  check_run(subject, checks);
}

void check_shape_contract(const Subject& subject, Checks& checks) {
  for (const Terrain& terrain : {terrains(9, 7).front(), terrains(17, 13)[1]}) {
    checks.at(terrain.name);
    checks.runs("gives finite positions, one a node", [&] {
      const auto made = subject.make<Shape>(terrain);
      const auto& a = made.surface->parameters();
      const Vec2 size(1.0, 0.8);
      const NodeVectors r = made.object->positions(a, size);
      checks.holds("same bits when asked again", r == made.object->positions(a, size),
                   "the second answer differs from the first");
      checks.report("extent along its largest side", characteristic_length(r), "m");
    });
  }
  check_run(subject, checks);
}

}  // namespace deform
