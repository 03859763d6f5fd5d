/// Linear and angular momentum. Without forces from outside, constraints and damping neither
/// changes: what does, the method did.
#include <Eigen/Geometry>

#include <deform/record/probe.h>

namespace {

using namespace deform;

class Momentum final : public Probe {
 public:
  Momentum(const NoParameters& /*parameters*/, const Setup& /*setup*/) {}

  [[nodiscard]] std::vector<ProbeColumn> columns() const override {
    std::vector<ProbeColumn> columns;
    for (const char* name : {"momentum.px", "momentum.py", "momentum.pz"})
      columns.push_back({name, "kg·m/s"});
    for (const char* name : {"momentum.lx", "momentum.ly", "momentum.lz"})
      columns.push_back({name, "kg·m²/s"});
    return columns;
  }

  void measure(const Frame& frame, Values figures) override {
    const auto mass = frame.system.mass().head(frame.system.nodes());
    Vec3 linear = Vec3::Zero(), angular = Vec3::Zero();
    for (Index a = 0; a < mass.size(); ++a) {
      const Vec3 p = mass[a] * frame.state.v.row(a).transpose();
      linear += p;
      angular += Vec3(frame.positions().row(a)).cross(p);
    }
    for (std::size_t c = 0; c < 3; ++c) {
      figures[c] = linear[static_cast<Index>(c)];
      figures[3 + c] = angular[static_cast<Index>(c)];
    }
  }
};

}  // namespace

DEFORM_PLUGIN(Momentum, NoParameters, .name = "momentum", .version = "1.0",
              .summary = "Linear momentum, and angular momentum about the origin",
              .formula = "p = sum of m v; l = sum of r x m v", .source = "")
