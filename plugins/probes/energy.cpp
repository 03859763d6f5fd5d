/// Energies: of every energy term, kinetic, external, and their sums.
#include <deform/record/probe.h>

namespace {

using namespace deform;

class Energy final : public Probe {
 public:
  Energy(const NoParameters& /*parameters*/, const Setup& /*setup*/) {}

  void begin(const RunContext& context) override {
    columns_.clear();
    for (const auto& term : context.system.energies())
      columns_.push_back({"energy." + term.name, "J"});
    for (const char* sum : {"kinetic", "internal", "external", "total"})
      columns_.push_back({std::string("energy.") + sum, "J"});
  }

  [[nodiscard]] std::vector<ProbeColumn> columns() const override { return columns_; }

  void measure(const Frame& frame, Values figures) override {
    const System& system = frame.system;
    const std::size_t terms = system.energies().size();
    double internal = 0;
    for (std::size_t i = 0; i < terms; ++i) {
      figures[i] = system.terms().energy(i, frame.state);
      internal += figures[i];
    }
    const double kinetic = 0.5 * system.mass().dot(frame.state.v.rowwise().squaredNorm());
    const double external = system.terms().external_potential(frame.state);
    figures[terms] = kinetic;
    figures[terms + 1] = internal;
    figures[terms + 2] = external;
    figures[terms + 3] = kinetic + internal + external;
  }

 private:
  std::vector<ProbeColumn> columns_;
};

}  // namespace

DEFORM_PLUGIN(Energy, NoParameters, .name = "energy", .version = "1.0",
              .summary =
                  "Energy of each term, kinetic, internal, external (force fields that have "
                  "a potential), total",
              .formula = "kinetic = sum of m |v|^2 / 2; total = kinetic + internal + external",
              .source = "Wu and Melo (17), (18)")
