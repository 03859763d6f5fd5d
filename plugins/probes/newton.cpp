/// What Newton's method took.
#include <deform/record/probe.h>

namespace {

using namespace deform;

class Newton final : public Probe {
 public:
  Newton(const NoParameters& /*parameters*/, const Setup& /*setup*/) {}

  [[nodiscard]] std::vector<ProbeColumn> columns() const override {
    return {{"newton.iterations", ""},
            {"newton.substeps", ""},
            {"newton.residual", "1"},
            {"newton.potential_change", "J"}};
  }

  void measure(const Frame& frame, Values figures) override {
    const StepReport& report = frame.system.step_report();
    figures[0] = static_cast<double>(report.iterations);
    figures[1] = static_cast<double>(report.substeps);
    figures[2] = report.residual;
    figures[3] = report.potential_change;
  }
};

}  // namespace

DEFORM_PLUGIN(Newton, NoParameters, .name = "newton", .version = "1.0",
              .summary =
                  "iterations, substeps, last relative residual of the last step; by how much an "
                  "implicit step's incremental potential changed",
              .formula = "", .source = "")
