#include <deform/model/force_field.h>
#include <deform/surface/surface.h>

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
class PointLoad final : public ForceField {
 public:
  PointLoad(const Parameters& p, const Setup& setup)
      : force_(p.force), time_(p.time), share_(area_shares(p.where, setup)) {}

  [[nodiscard]] ForceTraits traits() const override { return {.potential = true}; }

  void add_force(const NodeBlock& nodes, Vectors force) const override {
    const Vec3 total = time_(nodes.time) * force_;
    for (Index i = 0; i < nodes.size; ++i) force.add(i, share_[nodes.first + i] * total);
  }
  void add_potential(const NodeBlock& nodes, Values energy) const override {
    const Vec3 total = time_(nodes.time) * force_;
    for (Index i = 0; i < nodes.size; ++i)
      energy[i] -= share_[nodes.first + i] * total.dot(nodes.r[i]);
  }

 private:
  Vec3 force_;
  TimeProfile time_;
  NodeValues share_;  // (N)
};

}  // namespace

DEFORM_PLUGIN(PointLoad, Parameters, .name = "point_load", .version = "1.0",
              .summary = "a given total force on some nodes",
              .formula = "f_a = F A_a / Σ A over the selected nodes", .source = "Wu & Melo (16)")
