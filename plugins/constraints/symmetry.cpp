#include <cmath>

#include <deform/geometry/characteristic_length.h>
#include <deform/geometry/rounding.h>
#include <deform/model/constraint.h>

#include "../sides.h"

namespace {
using namespace deform;

constexpr const char* kFromShape = "from_shape";

struct Parameters {
  NodeSelection where;
  std::string plane = kFromShape;
  static void declare(Declaration<Parameters>& d) {
    d("where", &Parameters::where, "", "open sides: {\"boundary\": names}").required();
    d("plane", &Parameters::plane, "",
      "axis that the plane of symmetry is normal to; from_shape: that of the plane in which the "
      "initial side lies and which the surface meets at a right angle")
        .one_of({kFromShape, "x", "y", "z"});
  }
};

/// How far the nodes of a side may lie off their plane, as a part of the surface's extent.
constexpr double kFlatness = 1e-9;
/// Cosine of the angle between the surface and its plane's normal, at least: differences over three
/// nodes do not see a curved surface's right angle exactly.
constexpr double kRightAngle = 0.95;

/// The axis normal to a plane in which the side lies and which the surface meets at a right angle.
int axis_of(const Side& side, const NodeVectors& initial, const std::string& pointer) {
  for (int c = 0; c < 3; ++c) {
    const double at = initial(side.nodes.front().node, c);
    const double slack =
        kFlatness * characteristic_length(initial) + rounding_of_positions(initial);
    if (std::ranges::all_of(side.nodes, [&](const EdgeNode& edge) {
          const Vec3 across = derivative(edge.inwards, initial);
          return std::abs(initial(edge.node, c) - at) <= slack &&
                 std::abs(across[c]) >= kRightAngle * across.norm();
        }))
      return c;
  }
  throw InputError(
      {{pointer, "the initial side '" + side.name +
                     "' does not lie in a plane normal to an axis that the surface meets at a "
                     "right angle; where that is wanted all the same, say which \"plane\""}});
}

/// Half of a surface that goes on, mirrored, beyond a side.
class Symmetry final : public Constraint {
 public:
  Symmetry(const Parameters& p, const Setup& setup) : initial_(setup.surface().initial()) {
    for (const Side& side : select_sides(p.where, setup)) {
      const int normal =
          p.plane == kFromShape ? axis_of(side, initial_, p.where.pointer) : p.plane[0] - 'x';
      for (const EdgeNode& edge : side.nodes) {
        held_.push_back({edge.node, normal});
        for (int c = 0; c < 3; ++c)
          if (c != normal) ties_.push_back(no_slope(edge, c));
      }
    }
  }

  void reduce(Reduction& reduction) const override {
    for (const auto& [node, c] : held_) reduction.prescribe(node, c);
    for (const Tie& tie : ties_) reduction.tie(tie);
  }
  void prescribe(double /*time*/, NodeVectors& r) const override {
    for (const auto& [node, c] : held_) r(node, c) = initial_(node, c);
  }

 private:
  /// Σ c_k (r_k − r_k(0)) = 0, solved for the edge node itself: of a shape that is symmetric the
  /// nodes' derivative is 0 but for the error of its differences, which must not become a load.
  [[nodiscard]] Tie no_slope(const EdgeNode& edge, int c) const {
    double own = 0;
    for (const auto& [node, coefficient] : edge.inwards)
      if (node == edge.node) own += coefficient;
    if (own == 0)
      throw InputError("the derivative across the side at node " + std::to_string(edge.node) +
                       " does not depend on that node");
    Tie tie;
    tie.freedom = {edge.node, c};
    tie.offset = initial_(edge.node, c);
    for (const auto& [node, coefficient] : edge.inwards) {
      if (node == edge.node) continue;
      tie.parts.push_back({{node, c}, -coefficient / own});
      tie.offset += coefficient / own * initial_(node, c);
    }
    return tie;
  }

  NodeVectors initial_;  // (N × 3) [m]
  std::vector<Freedom> held_;
  std::vector<Tie> ties_;
};

}  // namespace

DEFORM_PLUGIN(Symmetry, Parameters, .name = "symmetry", .version = "1.0",
              .summary = "sides in a plane of symmetry, beyond which the surface's other half lies",
              .formula =
                  "⟨e, r_a(t)⟩ = ⟨e, r_a(0)⟩, e: normal of the plane; Σ c_k (r_k − r_k(0)) = 0 in "
                  "its other components, Σ c_k r_k: derivative across the side",
              .source = "")
