/// The guards of a run's balances of energy and momentum as one.
#pragma once

#include "simulation/energy_guard.h"
#include "simulation/momentum_guard.h"

namespace deform {

class BalanceGuards {
 public:
  BalanceGuards(const System& system, const Named<Integrator>& integrator)
      : energy_(system, integrator), momentum_(system, integrator) {}

  /// Whether the step that begins with this number of steps done is looked at: `begin` and `end`
  /// are called then, and `at_break` in between.
  [[nodiscard]] bool watches(long steps) const {
    return energy_.watches(steps) || momentum_.watches(steps);
  }
  void begin(const Frame& frame) {
    each(frame.step, [&](auto& guard) { guard.begin(frame); });
  }
  void at_break(const Frame& frame) {
    each(frame.step, [&](auto& guard) { guard.at_break(frame); });
  }
  void end(const Frame& frame) {
    each(frame.step - 1, [&](auto& guard) { guard.end(frame); });
  }

  /// The run ends with this state.
  void finish(const Frame& frame) { energy_.finish(frame); }

 private:
  template <class Action>
  void each(long steps, const Action& action) {
    if (energy_.watches(steps)) action(energy_);
    if (momentum_.watches(steps)) action(momentum_);
  }

  EnergyGuard energy_;
  MomentumGuard momentum_;
};

}  // namespace deform
