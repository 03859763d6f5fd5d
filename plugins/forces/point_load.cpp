#include <deform/surface/surface.h>

#include "dead_load.h"

namespace {
using namespace deform;

struct Parameters {
  Vec3 force = Vec3::Zero();
  NodeSelection where;
  TimeProfile time;
  static void declare(Declaration<Parameters>& d) {
    d("force", &Parameters::force, "N", "total force").required();
    d("where", &Parameters::where, "", "nodes that share it in proportion to their areas")
        .required();
    d("time", &Parameters::time, "1", "factor of the force over time");
  }
};

/// The part of the load that each node bears: area / Σ area where selected, else 0.
NodeValues area_shares(const NodeSelection& where, const Setup& setup) {
  const NodeValues& areas = setup.surface().areas();
  NodeValues share = NodeValues::Zero(areas.size());
  for (const Index node : setup.select(where)) share[node] = areas[node];
  return share / share.sum();
}

/// A dead load: it keeps its direction, and its total however fine the surface.
class PointLoad final : public DeadLoad {
 public:
  PointLoad(const Parameters& p, const Setup& setup)
      : DeadLoad(p.force, p.time, area_shares(p.where, setup)) {}
};

}  // namespace

DEFORM_PLUGIN(PointLoad, Parameters, .name = "point_load", .version = "1.0",
              .summary = "a given total force on some nodes",
              .formula = "f_a = F A_a / Σ A over the selected nodes", .source = "Wu & Melo (16)")
