#include <algorithm>
#include <cmath>

#include <deform/geometry/rounding.h>
#include <deform/model/constraint.h>

#include "../sides.h"

namespace {
using namespace deform;

struct Parameters {
  NodeSelection where;
  std::string tangent = "direction";
  static void declare(Declaration<Parameters>& d) {
    d("where", &Parameters::where, "", "open sides: {\"boundary\": names}").required();
    d("tangent", &Parameters::tangent, "",
      "what is held of the derivative t across the side: its direction (t stays in the tangent "
      "plane of the initial surface, and may grow or shrink), or all of it")
        .one_of({"direction", "full"});
  }
};

/// Components of a unit normal below this, or below what rounding of positions makes of
/// derivatives, are rounding: a flat side's tie names one component.
constexpr double kAlongAnAxis = 1e-12;

/// What rounding of positions may turn a derivative Σ c_k r_k by [rad].
double rounding_of_direction(const std::vector<EdgeNode::Entry>& row, const Vec3& derivative,
                             const NodeVectors& r) {
  double sum = 0;
  for (const EdgeNode::Entry& e : row) sum += std::abs(e.coefficient);
  return sum * rounding_of_positions(r) / derivative.norm();
}

/// The row's largest coefficient of a node that is not held (those of the sides, ascending): the
/// nearest node inside. Null where all are held, as in a corner: so is the derivative then.
const EdgeNode::Entry* nearest_inside(const EdgeNode& edge, const std::vector<Index>& held) {
  const EdgeNode::Entry* best = nullptr;
  bool is_alone = true;
  for (const EdgeNode::Entry& e : edge.inwards) {
    is_alone = is_alone && e.node == edge.node;
    if (!std::ranges::binary_search(held, e.node) &&
        (best == nullptr || std::abs(e.coefficient) > std::abs(best->coefficient)))
      best = &e;
  }
  if (is_alone)
    throw InputError("nothing lies across the side at node " + std::to_string(edge.node));
  return best;
}

/// direction · Σ c_k r_k stays what it is at first, solved for the nearest node inside and there
/// for the component that `direction` has most of.
Tie hold_derivative(const EdgeNode& edge, const EdgeNode::Entry& inside, const Vec3& direction,
                    const NodeVectors& initial) {
  Index largest = 0;
  direction.cwiseAbs().maxCoeff(&largest);
  const double pivot = inside.coefficient * direction[largest];
  Tie tie;
  tie.freedom = {inside.node, static_cast<int>(largest)};
  for (const auto& [node, coefficient] : edge.inwards)
    for (int c = 0; c < 3; ++c) {
      const Freedom freedom{node, c};
      if (direction[c] == 0 || freedom == tie.freedom) continue;
      tie.parts.push_back({freedom, -coefficient * direction[c] / pivot});
    }
  tie.offset = direction.dot(derivative(edge.inwards, initial)) / pivot;
  return tie;
}

/// Holds sides where they are at first, and the surface's direction across them.
class Clamp final : public Constraint {
 public:
  Clamp(const Parameters& p, const Setup& setup)
      : nodes_(setup.select(p.where)), initial_(setup.surface().initial()) {
    for (const Side& side : select_sides(p.where, setup))
      for (const EdgeNode& edge : side.nodes) {
        const EdgeNode::Entry* const inside = nearest_inside(edge, nodes_);
        if (inside == nullptr) continue;
        if (p.tangent == "full") {
          for (int c = 0; c < 3; ++c)
            ties_.push_back(hold_derivative(edge, *inside, Vec3::Unit(c), initial_));
        } else {
          ties_.push_back(hold_derivative(edge, *inside, initial_normal(edge), initial_));
        }
      }
  }

  void reduce(Reduction& reduction) const override {
    for (const Index node : nodes_)
      for (int c = 0; c < 3; ++c) reduction.prescribe(node, c);
    for (const Tie& tie : ties_) reduction.tie(tie);
  }
  void prescribe(double /*time*/, NodeVectors& r) const override {
    for (const Index node : nodes_) r.row(node) = initial_.row(node);
  }

 private:
  [[nodiscard]] Vec3 initial_normal(const EdgeNode& edge) const {
    const Vec3 across = derivative(edge.inwards, initial_),
               along = derivative(edge.along, initial_);
    const Vec3 area = across.cross(along);
    if (!(area.norm() > kAlongAnAxis * across.norm() * along.norm()))
      throw InputError("the initial surface has no normal at node " + std::to_string(edge.node) +
                       ", which is to be clamped");
    const double rounding = rounding_of_direction(edge.inwards, across, initial_) +
                            rounding_of_direction(edge.along, along, initial_);
    Vec3 n = area.normalized();
    for (int c = 0; c < 3; ++c)
      if (std::abs(n[c]) <= std::max(kAlongAnAxis, rounding)) n[c] = 0;
    return n;
  }

  std::vector<Index> nodes_;
  NodeVectors initial_;  // (N × 3) [m]
  std::vector<Tie> ties_;
};

}  // namespace

DEFORM_PLUGIN(Clamp, Parameters, .name = "clamp", .version = "1.0",
              .summary = "holds sides at their initial positions, and the direction across them",
              .formula =
                  "r_a(t) = r_a(0); ⟨n, Σ c_k r_k⟩ = its initial value, n: initial normal, "
                  "Σ c_k r_k: derivative across the side",
              .source = "")
