/// Sums of the internal and of the external forces. Internal forces must sum to zero: they cannot
/// move the centre of mass.
#include <deform/record/probe.h>

namespace {

using namespace deform;

class NetForce final : public Probe {
 public:
  NetForce(const NoParameters& /*parameters*/, const Setup& /*setup*/) {}

  [[nodiscard]] std::vector<ProbeColumn> columns() const override {
    return {{"net_force.internal.x", "N"}, {"net_force.internal.y", "N"},
            {"net_force.internal.z", "N"}, {"net_force.external.x", "N"},
            {"net_force.external.y", "N"}, {"net_force.external.z", "N"}};
  }

  void measure(const Frame& frame, Values figures) override {
    const System& system = frame.system;
    Vec3 internal = Vec3::Zero();
    for (std::size_t term = 0; term < system.energies().size(); ++term)
      internal +=
          system.terms().internal_force(term, frame.state).topRows(system.nodes()).colwise().sum();
    const Vec3 external =
        system.terms().external_force(frame.state).topRows(system.nodes()).colwise().sum();
    for (std::size_t c = 0; c < 3; ++c) {
      figures[c] = internal[static_cast<Index>(c)];
      figures[3 + c] = external[static_cast<Index>(c)];
    }
  }
};

}  // namespace

DEFORM_PLUGIN(NetForce, NoParameters, .name = "net_force", .version = "1.0",
              .summary =
                  "Sum over all nodes of the internal forces of all terms, and of the "
                  "external forces (reactions of constraints and damping excluded)",
              .formula = "sum of f", .source = "")
