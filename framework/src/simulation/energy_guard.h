/// Looks out for runs that gain energy from nowhere.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>

#include "deform/record/energy_account.h"
#include "deform/solve/integrator.h"

#include "simulation/guarded_steps.h"

namespace deform {

/// Takes the account of energy (EnergyAccount) of the guarded steps, and warns once where each of
/// those in a row has gained more than a twentieth of what moved: energy that neither loads nor
/// supports put in. Methods that damp lose some, and explicit ones take turns; only an unstable
/// method, or one that is wrong, goes on to gain.
///
/// Where all loads have a potential and neither they nor supports change in time, kinetic and
/// internal energy are also compared with what they were at first and what the loads' potential has
/// fallen by since: more than thrice that is from nowhere, whatever each step does.
///
/// What moves by no more than rounding does is not looked at. Of statics, where there is no motion,
/// and of terms without a potential nothing is known.
class EnergyGuard {
 public:
  EnergyGuard(const System& system, const Named<Integrator>& integrator);

  /// Whether the account of the step that begins with this number of steps done is taken: `begin`
  /// and `end` are called then, and `at_break` in between.
  [[nodiscard]] bool watches(long steps) const;
  void begin(const Frame& frame);
  void at_break(const Frame& frame);
  void end(const Frame& frame);
  /// Looks no more.
  void stop() { is_known_ = false; }
  /// The run ends with this state.
  void finish(const Frame& frame) {
    if (is_known_) compare_with_first(frame);
  }

 private:
  [[nodiscard]] bool gains() const;
  void compare_with_first(const Frame& frame);
  void warn(const std::string& what);

  EnergyAccount account_;
  bool is_known_;  // whether the model's energy is
  bool warned_ = false;
  /// Of the state that was seen first, where its forces are those of any time.
  struct First {
    double energy = 0;     // kinetic and internal [J]
    double potential = 0;  // of loads [J]
    double time = 0;       // [s]
  };
  std::optional<First> first_;
  bool is_conservative_ = true;                 // as far as is known
  double counted_ = 0;                          // of the step under way, up to breaks [s]
  long last_ = -1;                              // step that the account has come to
  double drift_ = 0;                            // until then [J]
  std::array<double, kGuardedInARow> gains_{};  // of the account's steps, relative
  std::size_t taken_ = 0;
};

}  // namespace deform
