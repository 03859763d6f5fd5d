/// The steps that an integrator chose.
#include <deform/record/probe.h>

namespace {

using namespace deform;

/// Of integrators that always take the scene's step, that is the smallest and the largest.
class TimeStep final : public Probe {
 public:
  TimeStep(const NoParameters& /*parameters*/, const Setup& /*setup*/) {}

  [[nodiscard]] std::vector<ProbeColumn> columns() const override {
    return {{"time_step.smallest", "s"},
            {"time_step.largest", "s"},
            {"time_step.substeps", ""},
            {"time_step.rejected", ""}};
  }

  void measure(const Frame& frame, Values figures) override {
    const StepReport& report = frame.system.step_report();
    const bool is_said = report.largest > 0;
    figures[0] = is_said ? report.smallest : frame.step_size;
    figures[1] = is_said ? report.largest : frame.step_size;
    figures[2] = static_cast<double>(report.substeps);
    figures[3] = static_cast<double>(report.rejected);
  }
};

}  // namespace

DEFORM_PLUGIN(TimeStep, NoParameters, .name = "time_step", .version = "1.0",
              .summary =
                  "smallest and largest substep of the last step, how many were taken and "
                  "how many tried in vain",
              .formula = "", .source = "")
