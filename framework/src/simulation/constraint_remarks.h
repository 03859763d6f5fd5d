/// Constraints that a user may not have meant as they are.
#pragma once

#include <vector>

#include "deform/simulation/simulation.h"

namespace deform {

/// A remark, with its pointer, for each constraint that
/// - takes over components that an earlier one moves elsewhere at some time of the run: the later
///   one gives the value, and the motion is lost. What an earlier one leaves where it is at first
///   may be taken over: a clamp that is moved.
/// - puts nodes elsewhere at the run's start than where the surface begins, which tears it.
/// Looks at the times at which constraints are not smooth, the run's start and end, and the middles
/// between these.
[[nodiscard]] std::vector<Problem> constraint_remarks(Simulation& simulation);

}  // namespace deform
