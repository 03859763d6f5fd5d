/// Loads at the ends of a step, where they may jump.
#pragma once

#include "deform/export.h"
#include "deform/record/frame.h"

namespace deform {

/// Forces of all force fields (N × 3) [N] at one time: what they were until then, and what they are
/// from then on. The two differ where a load jumps (Plugin::next_break).
struct LoadsAt {
  NodeVectors before, after;
};

/// At a frame that ends a step, or the part of one, of `length` seconds.
[[nodiscard]] DEFORM_API LoadsAt loads_at(const Frame& frame, double length);

}  // namespace deform
