#include <deform/model/force_field.h>

#include "../sides.h"

namespace {
using namespace deform;

struct Parameters {
  Vec3 force = Vec3::Zero();
  NodeSelection where;
  TimeProfile time;
  static void declare(Declaration<Parameters>& d) {
    d("force", &Parameters::force, "N/m", "force per length of the side, in parameters").required();
    d("where", &Parameters::where, "", "open sides: {\"boundary\": names}").required();
    d("time", &Parameters::time, "1", "factor of the force over time");
  }
};

/// The length of the loaded sides that each node stands for; of both where two meet.
NodeValues lengths(const NodeSelection& where, const Setup& setup) {
  NodeValues length = NodeValues::Zero(setup.surface().nodes());
  for (const Side& side : select_sides(where, setup))
    for (const EdgeNode& edge : side.nodes) length[edge.node] += edge.length;
  return length;
}

/// A dead load along sides: it keeps its direction, and its size when they are stretched.
class EdgeLoad final : public ForceField {
 public:
  EdgeLoad(const Parameters& p, const Setup& setup)
      : force_(p.force), time_(p.time), length_(lengths(p.where, setup)) {}

  [[nodiscard]] ForceTraits traits() const override { return {.potential = true}; }

  void add_force(const NodeBlock& nodes, Vectors force) const override {
    const Vec3 density = time_(nodes.time) * force_;
    for (Index i = 0; i < nodes.size; ++i) force.add(i, length_[nodes.first + i] * density);
  }
  void add_potential(const NodeBlock& nodes, Values energy) const override {
    const Vec3 density = time_(nodes.time) * force_;
    for (Index i = 0; i < nodes.size; ++i)
      energy[i] -= length_[nodes.first + i] * density.dot(nodes.r[i]);
  }

 private:
  Vec3 force_;  // [N/m]
  TimeProfile time_;
  NodeValues length_;  // (N) [m]
};

}  // namespace

DEFORM_PLUGIN(EdgeLoad, Parameters, .name = "edge_load", .version = "1.0",
              .summary = "a dead load per length of open sides",
              .formula = "f_a = F l_a, l_a: length of the side that the node stands for",
              .source = "")
