/// The centre of mass.
#include <deform/record/probe.h>

namespace {

using namespace deform;

class CentreOfMass final : public Probe {
 public:
  CentreOfMass(const NoParameters& /*parameters*/, const Setup& /*setup*/) {}

  [[nodiscard]] std::vector<ProbeColumn> columns() const override {
    return {{"centre_of_mass.x", "m"}, {"centre_of_mass.y", "m"}, {"centre_of_mass.z", "m"}};
  }

  void measure(const Frame& frame, Values figures) override {
    const auto mass = frame.system.mass().head(frame.system.nodes());
    const Vec3 centre = frame.positions().transpose() * mass / mass.sum();
    for (std::size_t c = 0; c < 3; ++c) figures[c] = centre[static_cast<Index>(c)];
  }
};

}  // namespace

DEFORM_PLUGIN(CentreOfMass, NoParameters, .name = "centre_of_mass", .version = "1.0",
              .summary = "Mass-weighted mean position of the nodes",
              .formula = "sum of m r / sum of m", .source = "")
