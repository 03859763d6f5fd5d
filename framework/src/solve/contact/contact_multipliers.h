/// Contact with colliders inside an implicit step: normal forces and friction as multipliers.
#pragma once

#include <utility>
#include <vector>

#include "deform/solve/collider_contact.h"
#include "deform/solve/implicit_stage.h"
#include "deform/solve/newton_matrix.h"

#include "solve/contact/contact_law.h"

namespace deform {

/// The augmented Lagrangian of gap ≥ 0 and of Coulomb's law (Alart & Curnier 1991; Simo & Laursen
/// 1992): with penalties κ, at each node and collider,
///   normal force N = max(0, λ − κ gap),
///   friction T = what is within the disk of radius μ λ, nearest to λ_T − κ u_T,
/// u_T being how far the node slid since the step began, across the normal and as far as nothing
/// prescribes where it goes. Both are gradients of
/// potentials while λ, λ_T and the disk are kept; then these are updated to N, T and μ N until
/// nothing changes: then the laws hold exactly, whatever κ.
class ContactMultipliers {
 public:
  /// Begins a stage; makes penalties from its stiffness at each node (N) [N/m], which is positive.
  /// `contact` must live until the next one. Throws InputError where multipliers were loaded that
  /// are another system's.
  void begin(const ColliderContact& contact, const NodeValues& stiffness);
  /// Finds active contacts at positions r of a stage.
  void find(const Stage& stage, const NodeVectors& r);
  /// Of the last `find`: adds contact forces [N] to f; their tangent −∂f/∂r [N/m]; their potential
  /// [J].
  void add_force(NodeVectors& f) const;
  [[nodiscard]] const std::vector<BlockEntry>& tangent();
  [[nodiscard]] double potential() const;
  /// Makes the forces of the last `find`, which was at positions r, the multipliers. What came to r
  /// through a body gets the tangent plane where it came in as the body's surface, for as long as
  /// the stage lasts: then only, as the straight ways to the iterates of Newton's method mean
  /// nothing. Finds what touches then; returns whether there are new planes.
  bool update(const Stage& stage, const NodeVectors& r);
  /// A stage was solved: multipliers that stopped what came to a collider are forgotten, as the
  /// next stage has nothing to stop; those of lasting contact it starts from.
  void forget_impacts(const Stage& stage, const NodeValues& mass);

  /// Nodes with a normal force at the last `find`, ascending, once for each collider.
  [[nodiscard]] std::vector<Index> active_nodes() const;
  /// What its forces change of velocities within the stage.
  [[nodiscard]] std::vector<ContactImpulse> impulses(const Stage& stage,
                                                     const NodeValues& mass) const;

  void save(Memory& memory) const;
  /// Throws InputError where a number cannot be one that was saved. "last.r" of the memory:
  /// positions of the step that they are of.
  void load(const Memory& memory);
  void forget();

 private:
  struct NormalForce {
    NodeContact contact;
    double force = 0;  // N
  };
  /// Friction where there was a normal force at the last update.
  struct Friction {
    Index node = 0;
    std::size_t body = 0;
    Vec3 normal = Vec3::UnitZ();                        // then
    Eigen::Matrix3d sliding = Eigen::Matrix3d::Zero();  // projects on the directions of u_T
    double limit = 0;                                   // μ λ
    Vec3 kept = Vec3::Zero();                           // λ_T
    Vec3 trial = Vec3::Zero();                          // λ_T − κ u_T
    Vec3 force = Vec3::Zero();                          // T
    [[nodiscard]] bool sticks() const { return trial.norm() <= limit; }
  };
  /// The friction kept for a contact; null where there is none.
  [[nodiscard]] const Friction* friction_of(const NodeContact& c) const;
  [[nodiscard]] std::size_t place_of(std::size_t body, Index node) const {
    return body * static_cast<std::size_t>(nodes_) + static_cast<std::size_t>(node);
  }
  [[nodiscard]] double& lambda(const NodeContact& c) { return lambda_[place_of(c.body, c.node)]; }
  /// κ of a contact: of the stiffness that the node has along the normal, as it is free to move.
  [[nodiscard]] double penalty(const NodeContact& c) const { return penalty_[c.node] / c.mobility; }
  void load_friction(const std::vector<double>& all, std::size_t nodes);
  /// Projects on the directions in which a node can slide on a body with that normal.
  [[nodiscard]] Eigen::Matrix3d sliding(Index node, const Vec3& n) const;
  /// Positions at the stage's end.
  [[nodiscard]] static NodeVectors end_of(const Stage& stage, const NodeVectors& r);
  bool add_planes(const Stage& stage, const NodeVectors& end);
  /// Contacts of nodes that have planes become those with them.
  void use_planes(const NodeVectors& end, std::vector<NodeContact>& near) const;

  Index nodes_ = 0;
  NodeValues penalty_;               // κ of each node [N/m]
  double reach_ = 1;                 // of the last stage: forces by r are κ · reach
  std::vector<double> lambda_;       // of each collider's nodes [N]
  std::vector<NormalForce> normal_;  // collider by collider, nodes ascending
  std::vector<Friction> friction_;   // likewise
  /// Tangent plane where a node has come into a collider that it would cross.
  struct Plane {
    NodeContact contact;
    double offset = 0;  // [m] normal · position at gap 0
    [[nodiscard]] std::pair<std::size_t, Index> place() const {
      return {contact.body, contact.node};
    }
  };
  std::vector<Plane> planes_;  // likewise
  const ColliderContact* contact_ = nullptr;
  std::vector<BlockEntry> tangent_;  // kept for its memory
};

}  // namespace deform
