/// The guards of a run's balances of energy and momentum as one.
#pragma once

#include <string>

#include "deform/error.h"
#include "deform/log.h"

#include "simulation/energy_guard.h"
#include "simulation/momentum_guard.h"

namespace deform {

/// They look on, and end no run: where one cannot evaluate what it needs, it looks no more.
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
  void finish(const Frame& frame) {
    look(energy_, [&](EnergyGuard& guard) { guard.finish(frame); });
  }

 private:
  template <class Action>
  void each(long steps, const Action& action) {
    if (energy_.watches(steps)) look(energy_, action);
    if (momentum_.watches(steps)) look(momentum_, action);
  }
  template <class Guard, class Action>
  static void look(Guard& guard, const Action& action) {
    try {
      action(guard);
    } catch (const Error& e) {
      if (e.code() == ExitCode::interrupted) throw;
      log::debug(std::string("the account of energy or momentum ends: ") + e.what());
      guard.stop();
    }
  }

  EnergyGuard energy_;
  MomentumGuard momentum_;
};

}  // namespace deform
