#include "simulation/energy_guard.h"

#include <algorithm>

#include <fmt/format.h>

#include "deform/log.h"

namespace deform {
namespace {

/// Steps from one account to the next, once there have been so many.
constexpr long kInterval = 64;
/// Part of what moved that a step may gain.
constexpr double kMost = 0.05;

bool knows_energy(const System& system, const Integrator& integrator) {
  return !integrator.is_static() && std::ranges::all_of(system.energies(), [](const auto& e) {
    return e.object->traits().potential;
  });
}

}  // namespace

EnergyGuard::EnergyGuard(const System& system, const Integrator& integrator)
    : account_(system), is_known_(knows_energy(system, integrator)) {}

bool EnergyGuard::watches(long steps) const {
  const long step = steps + 1;
  const bool is_early = step < kInterval && (step & (step - 1)) == 0;
  return is_known_ && !warned_ && (is_early || step % kInterval == 0);
}

void EnergyGuard::begin(const Frame& frame) {
  account_.start(frame);
  counted_ = 0;
}

void EnergyGuard::at_break(const Frame& frame) {
  account_.add_part(frame, frame.step_size);
  counted_ += frame.step_size;
}

void EnergyGuard::end(const Frame& frame) {
  account_.add_part(frame, frame.step_size - counted_);
  const EnergyFigures figures = account_.figures(frame);
  gains_[taken_++ % kInARow] = figures.scale() > 0 ? figures.drift() / figures.scale() : 0;
  if (gains()) warn(frame, figures);
}

bool EnergyGuard::gains() const {
  return taken_ >= kInARow && std::ranges::all_of(gains_, [](double gain) { return gain > kMost; });
}

void EnergyGuard::warn(const Frame& frame, const EnergyFigures& figures) {
  warned_ = true;
  log::warn(fmt::format(
      "the run gains energy from nowhere: {:.3g} J in step {} ({:.2g} of what moved), which "
      "neither loads nor supports put in, and likewise in earlier steps. The method is unstable "
      "with this step, or a term's force is not the gradient of its energy: try a shorter "
      "/integrator/step, 'backward_euler' or 'bdf2'; the probe energy_balance shows the account",
      figures.drift(), frame.step, figures.drift() / figures.scale()));
}

}  // namespace deform
