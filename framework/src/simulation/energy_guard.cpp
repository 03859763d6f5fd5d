#include "simulation/energy_guard.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "deform/geometry/characteristic_length.h"
#include "deform/log.h"

#include "solve/asked.h"

namespace deform {
namespace {

/// Part of what moved that a step may gain.
constexpr double kMost = 0.05;
/// So many times what there was may be there later.
constexpr double kManyTimes = 3;
/// Motion by less than this part of the surface's size a step is rounding.
constexpr double kStill = 1e-8;
/// Part of an energy that is its rounding, or what Newton's method leaves.
constexpr double kRounding = 1e-9;

bool knows_energy(const System& system, const Named<Integrator>& integrator) {
  return !is_static(integrator) && have_potential(system);
}

double kinetic_and_internal(const Frame& frame) {
  double sum = 0.5 * frame.system.mass().dot(frame.state.v.rowwise().squaredNorm());
  for (std::size_t i = 0; i < frame.system.energies().size(); ++i)
    sum += frame.system.terms().energy(i, frame.state);
  return sum;
}

/// Kinetic energy where all of the surface moves by kStill of its size in a step [J].
double energy_of_rounding(const Frame& frame) {
  const double speed = kStill * characteristic_length(frame.system.rest()) / frame.step_size;
  return 0.5 * frame.system.mass().sum() * speed * speed;
}

/// Whether loads, supports, bodies and materials are at two times the same, as far as this state
/// shows.
bool is_unchanged(const Frame& frame, double earlier) {
  const System& system = frame.system;
  if (system.next_break(earlier) <= frame.state.time) return false;
  NodeVectors now = frame.state.r, then = frame.state.r;
  system.constraints().prescribe(frame.state.time, now);
  system.constraints().prescribe(earlier, then);
  if (now != then) return false;
  State at_earlier = frame.state;
  at_earlier.time = earlier;
  const auto is_same = [](double a, double b) {
    return std::abs(a - b) <= kRounding * (std::abs(a) + std::abs(b));
  };
  for (std::size_t i = 0; i < system.energies().size(); ++i)
    if (!is_same(system.terms().energy(i, at_earlier), system.terms().energy(i, frame.state)))
      return false;
  NodeVectors carried;  // bodies that move put energy in
  for (std::size_t b = 0; b < system.contact().bodies(); ++b)
    if (system.contact().carry(b, earlier, frame.state.time, frame.positions(), carried))
      return false;
  if (system.contact().bodies() > 0 &&
      system.contact().clearance(earlier, frame.positions()) !=
          system.contact().clearance(frame.state.time, frame.positions()))
    return false;
  return is_same(system.terms().external_potential(at_earlier),
                 system.terms().external_potential(frame.state));
}

}  // namespace

EnergyGuard::EnergyGuard(const System& system, const Named<Integrator>& integrator)
    : account_(system), is_known_(knows_energy(system, integrator)) {
  is_conservative_ = is_known_ && system.evaluator().without_potential().empty();
}

bool EnergyGuard::watches(long steps) const { return is_known_ && !warned_ && is_guarded(steps); }

void EnergyGuard::begin(const Frame& frame) {
  counted_ = 0;
  if (frame.step == last_) return;
  compare_with_first(frame);
  account_.start(frame);
  drift_ = 0;
  taken_ = 0;
}

void EnergyGuard::at_break(const Frame& frame) {
  account_.add_part(frame, frame.step_size, EnergyAccount::End::at_break);
  counted_ += frame.step_size;
}

void EnergyGuard::end(const Frame& frame) {
  account_.add_part(frame, frame.step_size - counted_, EnergyAccount::End::of_step);
  last_ = frame.step;
  const EnergyFigures figures = account_.figures(frame);
  const double gain = figures.drift() - drift_;
  drift_ = figures.drift();
  const double least = energy_of_rounding(frame) + kRounding * kinetic_and_internal(frame);
  const double relative = figures.scale() > 0 && gain > least ? gain / figures.scale() : 0;
  gains_[taken_++ % gains_.size()] = relative;
  if (gains())
    warn(
        fmt::format("{:.3g} J in step {} ({:.2g} of what moved), which neither loads nor supports "
                    "put in, and likewise in the steps before",
                    gain, frame.step, relative));
}

bool EnergyGuard::gains() const {
  return taken_ >= gains_.size() &&
         std::ranges::all_of(gains_, [](double gain) { return gain > kMost; });
}

/// With loads that keep their potential, kinetic and internal energy grow by what that falls, at
/// most.
void EnergyGuard::compare_with_first(const Frame& frame) {
  if (warned_ || !is_conservative_) return;
  const double energy = kinetic_and_internal(frame);
  const double potential = frame.system.terms().external_potential(frame.state);
  if (!first_) {
    first_ = {energy, potential, frame.state.time};
    return;
  }
  is_conservative_ = is_unchanged(frame, first_->time);
  const double known = first_->energy + std::max(0.0, first_->potential - potential);
  const double rounding = energy_of_rounding(frame) + kRounding * std::abs(potential);
  if (is_conservative_ && energy > known + (kManyTimes - 1) * std::abs(known) + rounding)
    warn(
        fmt::format("{:.3g} J are in motion and strain at step {}, where there were {:.3g} J at "
                    "first and what the loads did since",
                    energy, frame.step, known));
}

void EnergyGuard::warn(const std::string& what) {
  warned_ = true;
  log::warn("the run gains energy from nowhere: " + what +
            ". The method is unstable with this step, or a term's force is not the gradient of its "
            "energy: try a shorter /integrator/step, 'backward_euler' or 'bdf2'; the probe "
            "energy_balance shows the account");
}

}  // namespace deform
