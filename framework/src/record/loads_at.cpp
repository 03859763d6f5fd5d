#include "deform/record/loads_at.h"

#include <cmath>
#include <limits>

namespace deform {
namespace {

/// Part of a step by which times of breaks may be wrong.
constexpr double kRounding = 1e-9;

}  // namespace

LoadsAt loads_at(const Frame& frame, double length) {
  const double time = frame.state.time;
  const double rounding =
      kRounding * length + 16 * std::numeric_limits<double>::epsilon() * std::abs(time);
  if (!(frame.system.next_break(time - rounding) <= time + rounding)) {
    NodeVectors load = frame.system.terms().external_force(frame.state);
    return {.before = load, .after = std::move(load)};
  }
  State beside = frame.state;
  beside.time = time - 2 * rounding;
  NodeVectors before = frame.system.terms().external_force(beside);
  beside.time = time + 2 * rounding;
  return {.before = std::move(before), .after = frame.system.terms().external_force(beside)};
}

}  // namespace deform
