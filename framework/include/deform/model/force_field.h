/// Force fields: external forces on the nodes.
#pragma once

#include <utility>
#include <vector>

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
  ConstValues area;     ///< of each node [m²], of the surface that mass goes by: Setup::areas()
  ConstValues mass;     ///< [kg]
  ConstVectors all_r;   ///< positions of all nodes, by number [m]; only when traits().neighbours
  ConstVectors all_v;   ///< velocities, likewise [m/s]
};

struct ForceTraits {
  bool normals = false;    ///< reads NodeBlock::normal
  bool potential = false;  ///< offers `potential`
  /// Offers `add_tangent`, whose ∂f/∂r and ∂f/∂v are scalar multiples of the identity: linearly
  /// implicit steps, one N × N matrix for x, y and z, then take the force implicitly.
  bool isotropic_tangent = false;
  /// Reads NodeBlock::all_r and all_v: a node's force depends on other nodes, too (forces on
  /// faces).
  bool neighbours = false;
  /// Offers `add_tangent` with a damping d that only bounds −∂f/∂v, and no stiffness:
  /// −Σ_ab w_a·(∂f_a/∂v_b) w_b ≤ Σ_a d_a |w_a|² for all w. Linearly implicit steps take
  /// f(v⁺) ≈ f(v) − d (v⁺ − v): of first order in the step, as with the tangent itself, and the
  /// bound sees to it that drag cannot overshoot.
  bool damping_bound = false;
  /// Offers `tangent_pairs` and `add_exact_tangent`: Newton steps then converge quadratically.
  bool exact_tangent = false;
  /// Offers `tangent_pairs` and `add_exact_damping`: Newton steps then take that in place of a
  /// bound.
  bool exact_damping = false;
};

/// An external force. Contract: const and thread-safe on blocks of nodes; adds; a node's force
/// depends on that node alone unless traits().neighbours. The same bits however the nodes are cut
/// into blocks: what a node shares with others, it computes for itself, in a fixed order.
class DEFORM_API ForceField : public Plugin {
 public:
  static constexpr PluginKind kKind = PluginKind::force;
  ~ForceField() override;

  [[nodiscard]] virtual ForceTraits traits() const { return {}; }
  /// Adds the force on each node [N].
  virtual void add_force(const NodeBlock& nodes, Vectors force) const = 0;
  /// Adds −∂f/∂r [N/m] and −∂f/∂v [N·s/m] of each node (the scalar factors of the identity), or
  /// the damping that bounds it.
  virtual void add_tangent(const NodeBlock& nodes, Values stiffness, Values damping) const;
  /// Pairs (a, b), a ≤ b, of nodes whose forces depend on each other's (or, a = b, their own)
  /// positions or velocities, each once; fixed for the object's life.
  [[nodiscard]] virtual std::vector<std::pair<Index, Index>> tangent_pairs() const;
  /// Adds −∂f_a/∂r_b [N/m] of each of these pairs, in their order; `nodes` are all nodes. Where it
  /// is not symmetric, as of a load that follows the surface, blocks with a ≠ b are to be those of
  /// its symmetric part; blocks with a = b are made symmetric.
  virtual void add_exact_tangent(const NodeBlock& nodes, std::span<Eigen::Matrix3d> blocks) const;
  /// Adds −∂f_a/∂v_b [N·s/m] of each of these pairs, in their order, likewise; positive
  /// semi-definite as a whole.
  virtual void add_exact_damping(const NodeBlock& nodes, std::span<Eigen::Matrix3d> blocks) const;
  /// Adds the potential energy of each node [J]; the force is −∇ of their sum.
  virtual void add_potential(const NodeBlock& nodes, Values energy) const;
};

}  // namespace deform
