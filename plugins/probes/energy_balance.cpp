/// An account of energy over every step, recorded or not.
#include <algorithm>
#include <array>
#include <optional>

#include <deform/record/energy_account.h>
#include <deform/record/probe.h>

namespace {

using namespace deform;

class EnergyBalance final : public Probe {
 public:
  EnergyBalance(const NoParameters& /*parameters*/, const Setup& /*setup*/) {}

  void begin(const RunContext& context) override { account_.emplace(context.system); }

  [[nodiscard]] std::vector<ProbeColumn> columns() const override {
    return {{"energy_balance.change", "J"},      {"energy_balance.loads", "J"},
            {"energy_balance.constraints", "J"}, {"energy_balance.damping", "J"},
            {"energy_balance.drift", "J"},       {"energy_balance.relative_drift", "1"},
            {"energy_balance.contact", "J"},     {"energy_balance.friction", "J"}};
  }

  void follow(const Frame& frame) override {
    account_->add_part(frame, frame.step_size - counted_, EnergyAccount::End::of_step);
    counted_ = 0;
  }
  void follow_break(const Frame& frame) override {
    account_->add_part(frame, frame.step_size, EnergyAccount::End::at_break);
    counted_ += frame.step_size;
  }

  void measure(const Frame& frame, Values figures) override {
    if (!account_->has_started()) account_->start(frame);
    const EnergyFigures a = account_->figures(frame);
    const double relative = a.scale() > 0 ? a.drift() / a.scale() : 0;
    const std::array all{a.change,  a.loads,  a.constraints, a.damping,
                         a.drift(), relative, a.contact,     a.friction};
    std::ranges::copy(all, figures.begin());
  }

  void save(Memory& memory) const override { account_->save(memory); }
  void load(const Memory& memory) override { account_->load(memory); }

 private:
  std::optional<EnergyAccount> account_;
  double counted_ = 0;  // of the step under way, by calls of follow_break [s]
};

}  // namespace

DEFORM_PLUGIN(
    EnergyBalance, NoParameters, .name = "energy_balance", .version = "1.0",
    .summary =
        "Change of kinetic and internal energy (terms with a potential) since the start, work of "
        "loads and of constraints that move nodes, what damping took, all over every step; the "
        "drift, which is none of these: that of the method, of terms without a potential; and the "
        "work of colliders on the surface, along their normals and by friction",
    .formula =
        "drift = change - loads - constraints + damping - contact - friction; relative to |change| "
        "+ largest kinetic energy + sums of |work| and damping of each step")
