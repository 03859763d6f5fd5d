#include "simulation/energy_guard.h"

#include <algorithm>

#include <fmt/format.h>

#include "deform/log.h"

#include "solve/asked.h"

namespace deform {
namespace {

/// Part of what moved that a step may gain.
constexpr double kMost = 0.05;

bool knows_energy(const System& system, const Named<Integrator>& integrator) {
  return !is_static(integrator) && have_potential(system);
}

}  // namespace

EnergyGuard::EnergyGuard(const System& system, const Named<Integrator>& integrator)
    : account_(system), is_known_(knows_energy(system, integrator)) {}

bool EnergyGuard::watches(long steps) const { return is_known_ && !warned_ && is_guarded(steps); }

void EnergyGuard::begin(const Frame& frame) {
  counted_ = 0;
  if (frame.step == last_) return;
  account_.start(frame);
  drift_ = 0;
  taken_ = 0;
}

void EnergyGuard::at_break(const Frame& frame) {
  account_.add_part(frame, frame.step_size);
  counted_ += frame.step_size;
}

void EnergyGuard::end(const Frame& frame) {
  account_.add_part(frame, frame.step_size - counted_);
  last_ = frame.step;
  const EnergyFigures figures = account_.figures(frame);
  const double gain = figures.drift() - drift_;
  const double relative = figures.scale() > 0 ? gain / figures.scale() : 0;
  drift_ = figures.drift();
  gains_[taken_++ % gains_.size()] = relative;
  if (gains()) warn(frame, gain, relative);
}

bool EnergyGuard::gains() const {
  return taken_ >= gains_.size() &&
         std::ranges::all_of(gains_, [](double gain) { return gain > kMost; });
}

void EnergyGuard::warn(const Frame& frame, double gain, double relative) {
  warned_ = true;
  log::warn(fmt::format(
      "the run gains energy from nowhere: {:.3g} J in step {} ({:.2g} of what moved), which "
      "neither loads nor supports put in, and likewise in the steps before. The method is unstable "
      "with this step, or a term's force is not the gradient of its energy: try a shorter "
      "/integrator/step, 'backward_euler' or 'bdf2'; the probe energy_balance shows the account",
      gain, frame.step, relative));
}

}  // namespace deform
