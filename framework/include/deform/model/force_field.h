/// Force fields: external forces on the nodes.
#pragma once

#include "deform/plugin/descriptor.h"
#include "deform/types.h"

namespace deform {

/// Consecutive nodes of a state, as a force field sees them.
struct NodeBlock {
  Index first = 0;  ///< number of the block's first node
  Index size = 0;
  double time = 0;      ///< [s]
  ConstVectors r;       ///< positions [m]
  ConstVectors v;       ///< velocities [m/s]
  ConstVectors normal;  ///< exact unit normals; only when traits().normals
  ConstValues area;     ///< parameter area of each node [m²]
  ConstValues mass;     ///< [kg]
};

struct ForceTraits {
  bool normals = false;    ///< reads NodeBlock::normal
  bool potential = false;  ///< offers `potential`
  /// Offers `add_tangent`, whose ∂f/∂r and ∂f/∂v are scalar multiples of the identity: linearly
  /// implicit steps, one N × N matrix for x, y and z, then take the force implicitly.
  bool isotropic_tangent = false;
};

/// An external force. Contract: const and thread-safe on blocks of nodes; adds; a node's force
/// depends on that node alone.
class DEFORM_API ForceField : public Plugin {
 public:
  static constexpr PluginKind kKind = PluginKind::force;
  ~ForceField() override;

  [[nodiscard]] virtual ForceTraits traits() const { return {}; }
  /// Adds the force on each node [N].
  virtual void add_force(const NodeBlock& nodes, Vectors force) const = 0;
  /// Adds −∂f/∂r [N/m] and −∂f/∂v [N·s/m] of each node (the scalar factors of the identity).
  virtual void add_tangent(const NodeBlock& nodes, Values stiffness, Values damping) const;
  /// Adds the potential energy of each node [J].
  virtual void add_potential(const NodeBlock& nodes, Values energy) const;
};

}  // namespace deform
