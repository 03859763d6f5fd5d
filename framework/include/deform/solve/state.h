/// A state of motion.
#pragma once

#include "deform/types.h"

namespace deform {

/// Positions [m], velocities [m/s] (both N × 3), and time [s]. Where a model has S scalar unknowns
/// (ScalarUnknown), both have S rows more, whose x they are.
struct State {
  NodeVectors r;
  NodeVectors v;
  double time = 0;
};

}  // namespace deform
