#include "../sides.h"
#include "dead_load.h"

namespace {
using namespace deform;

struct Parameters {
  Vec3 force = Vec3::Zero();
  NodeSelection where;
  TimeProfile time;
  static void declare(Declaration<Parameters>& d) {
    d("force", &Parameters::force, "N/m", "force per length of the side at rest").required();
    d("where", &Parameters::where, "", "open sides: {\"boundary\": names}").required();
    d("time", &Parameters::time, "1", "factor of the force over time");
  }
};

/// The length of the loaded sides that each node stands for; of both where two meet.
NodeValues lengths(const NodeSelection& where, const Setup& setup) {
  NodeValues length = NodeValues::Zero(setup.surface().nodes());
  for (const Side& side : select_sides(where, setup))
    for (const EdgeNode& edge : side.nodes) length[edge.node] += length_of(edge, setup);
  return length;
}

/// A dead load along sides: it keeps its direction, and its size when they are stretched.
class EdgeLoad final : public DeadLoad {
 public:
  EdgeLoad(const Parameters& p, const Setup& setup)
      : DeadLoad(p.force, p.time, lengths(p.where, setup)) {}
};

}  // namespace

DEFORM_PLUGIN(EdgeLoad, Parameters, .name = "edge_load", .version = "1.0",
              .summary = "a dead load per length of open sides",
              .formula = "f_a = F l_a, l_a: length of the side that the node stands for",
              .source = "")
