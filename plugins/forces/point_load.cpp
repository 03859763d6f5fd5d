#include "area_shares.h"
#include "dead_load.h"

namespace {
using namespace deform;

struct Parameters {
  Vec3 force = Vec3::Zero();
  NodeSelection where;
  TimeProfile time;
  static void declare(Declaration<Parameters>& d) {
    d("force", &Parameters::force, "N", "total force").required();
    d("where", &Parameters::where, "",
      "a patch of the surface, or nodes that share it in proportion to their areas")
        .required();
    d("time", &Parameters::time, "1", "factor of the force over time");
  }
};

/// A dead load: it keeps its direction, and its total however fine the surface.
class PointLoad final : public DeadLoad {
 public:
  PointLoad(const Parameters& p, const Setup& setup)
      : DeadLoad(p.force, p.time, area_shares(p.where, setup)) {}
};

}  // namespace

DEFORM_PLUGIN(PointLoad, Parameters, .name = "point_load", .version = "1.0",
              .summary = "a given total force on a patch or on some nodes",
              .formula = "f_a = F A_a / Σ A, A_a: area of the node that is selected",
              .source = "Wu & Melo (16)")
