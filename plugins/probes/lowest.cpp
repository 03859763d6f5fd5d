/// How deep the surface hangs.
#include <deform/record/probe.h>

namespace {

using namespace deform;

class Lowest final : public Probe {
 public:
  Lowest(const NoParameters& /*parameters*/, const Setup& /*setup*/) {}

  [[nodiscard]] std::vector<ProbeColumn> columns() const override { return {{"lowest", "m"}}; }

  void measure(const Frame& frame, Values figures) override {
    figures[0] = frame.positions().col(2).minCoeff();
  }
};

}  // namespace

DEFORM_PLUGIN(Lowest, NoParameters, .name = "lowest", .version = "1.0",
              .summary = "Lowest z of all nodes", .formula = "min over nodes of z", .source = "")
