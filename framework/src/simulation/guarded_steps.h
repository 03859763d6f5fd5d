/// Which steps of a run the guards of its balances look at.
#pragma once

namespace deform {

/// Steps that are looked at in a row; a fault of the method shows in each of them.
constexpr long kGuardedInARow = 4;

/// Whether the step that begins with this number of steps done is looked at: the first, four in a
/// row from the 17th on, and then every 256 steps, which costs next to nothing.
constexpr bool is_guarded(long steps) {
  constexpr long kFirst = 16, kInterval = 256;
  return steps == 0 || (steps >= kFirst && (steps - kFirst) % kInterval < kGuardedInARow);
}

}  // namespace deform
