/// The motions of a surface as a rigid body that neither constraints nor force fields hold.
#pragma once

#include <vector>

#include "deform/model/reduction.h"
#include "deform/solve/block_matrix.h"
#include "deform/types.h"

namespace deform {

/// What force fields do against motions as a rigid body.
struct RigidStiffness {
  /// Second derivatives of their potential [N/m] along motions by unit lengths, or by angles that
  /// move the farthest component of a node by one: along and around x, y, z about the centre.
  Eigen::Matrix<double, 6, 6> second = Eigen::Matrix<double, 6, 6>::Zero();
  double least = 0;  ///< what is below is rounding [N/m]
};

/// Of forces f (N × 3) [N] with the stiffness k = −∂f/∂r at r (N × 3) [m]. Along a finite turn
/// nodes go round, which counts where there is a force: a pressure, or springs that all end in one
/// point, do not resist being turned, though their tangents alone do.
[[nodiscard]] RigidStiffness rigid_stiffness(const BlockMatrix& k, const NodeVectors& f,
                                             const NodeVectors& r);

/// As many free components as there are motions at positions r (N × 3) [m] that neither the
/// constraints nor `forces` hold, chosen so that holding them holds the surface. Holding them
/// changes no strain.
[[nodiscard]] std::vector<Freedom> components_to_hold(const ReductionMap& map, const NodeVectors& r,
                                                      const RigidStiffness& forces);

}  // namespace deform
