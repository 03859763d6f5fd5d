/// Unknowns that are no positions.
#pragma once

namespace deform {

/// An unknown beside the nodes' positions (an angle at an edge, a hidden coordinate, …), in units
/// of its owner's choice: forces on it are energies per unit, its mass is kg·m² per unit². It is
/// kept as the x of a further row of positions, of which y and z stay 0.
struct ScalarUnknown {
  double initial = 0;
  double mass = 0;     ///< 0: it is where forces on it balance; takes an implicit integrator
  double damping = 0;  ///< force per rate
};

}  // namespace deform
