/// Torques of the internal and of the external forces about the centroid of the nodes. Internal
/// forces must have none: they cannot turn the surface.
#include <Eigen/Geometry>

#include <deform/record/probe.h>

namespace {

using namespace deform;

Vec3 torque(const NodeVectors& r, const Vec3& about, const NodeVectors& force) {
  Vec3 sum = Vec3::Zero();
  for (Index a = 0; a < r.rows(); ++a) {
    const Vec3 arm = r.row(a).transpose() - about;
    sum += arm.cross(Vec3(force.row(a)));
  }
  return sum;
}

class NetTorque final : public Probe {
 public:
  NetTorque(const NoParameters& /*parameters*/, const Setup& /*setup*/) {}

  [[nodiscard]] std::vector<ProbeColumn> columns() const override {
    return {{"net_torque.internal.x", "N m"}, {"net_torque.internal.y", "N m"},
            {"net_torque.internal.z", "N m"}, {"net_torque.external.x", "N m"},
            {"net_torque.external.y", "N m"}, {"net_torque.external.z", "N m"}};
  }

  void measure(const Frame& frame, Values figures) override {
    const System& system = frame.system;
    const NodeVectors r = frame.positions();
    const Vec3 centroid = r.colwise().mean();
    Vec3 internal = Vec3::Zero();
    for (std::size_t term = 0; term < system.energies().size(); ++term)
      internal += torque(r, centroid, system.terms().internal_force(term, frame.state));
    const Vec3 external = torque(r, centroid, system.terms().external_force(frame.state));
    for (std::size_t c = 0; c < 3; ++c) {
      figures[c] = internal[static_cast<Index>(c)];
      figures[3 + c] = external[static_cast<Index>(c)];
    }
  }
};

}  // namespace

DEFORM_PLUGIN(NetTorque, NoParameters, .name = "net_torque", .version = "1.0",
              .summary =
                  "Torque, about the centroid of the present nodes (each counts the same), of "
                  "the internal forces of all terms, and of the external forces",
              .formula = "sum of (r - c) x f, c = mean of r", .source = "")
