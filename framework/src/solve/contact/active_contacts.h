/// Contact with colliders inside an implicit stage: an active set of nodes that touch.
#pragma once

#include <utility>
#include <vector>

#include "deform/solve/collider_contact.h"
#include "deform/solve/implicit_stage.h"
#include "deform/solve/newton_matrix.h"

#include "solve/contact/contact_law.h"

namespace deform {

/// A stage's positions r minimise its incremental potential Φ + D subject to gap ≥ 0 at the stage's
/// end. D is friction's: an augmented Lagrangian of Coulomb's law (Alart & Curnier 1991; Simo &
/// Laursen 1992), whose force T on a node is what is within the disk of radius μ N̂ nearest to
/// T̂ − κ u_T, u_T being how far the node slid on the body since the step began, across the normal
/// and as far as nothing prescribes where it goes. T̂ and the normal force N̂ are kept while Φ + D is
/// minimised, and then made T and N until nothing changes: then the law holds exactly, whatever κ.
///
/// Normal forces are no unknowns. Iterates are always admissible: nodes that a step would take into
/// a body are put on its surface (Bertsekas 1982, projected Newton methods), and a touching node's
/// normal force is what balances the other forces that push it into the body. So no node is inside
/// of a body by more than rounding. Newton's directions are those of the quadratic model under the
/// linearised constraints; which of these hold is found by turns (a primal–dual active set:
/// Hintermüller, Ito & Kunisch 2002).
class ActiveContacts {
 public:
  /// Begins a stage of a surface of some size [m] whose nodes have that stiffness (N) [N/m], which
  /// is positive: penalties are multiples of it. `contact` and `stage` must live as long. Throws
  /// InputError where friction was loaded that is another system's.
  void begin(const ColliderContact& contact, const Stage& stage, double size,
             const NodeValues& stiffness);
  /// Whether something touched at the last `react`, or was about to.
  [[nodiscard]] bool any() const { return !normal_.empty() || !friction_.empty(); }

  /// Puts positions r (N × 3) of the stage where contact admits them.
  void confine(NodeVectors& r) const;
  /// D at positions r [J].
  [[nodiscard]] double dissipation(const NodeVectors& r) const;
  /// Adds contact's reactions [N] to what other forces leave of the residual (N × 3) at r; who
  /// touches for the first time in the stage gets its N̂. Returns whether some did: D is then
  /// another function.
  bool react(const NodeVectors& r, NodeVectors& residual);

  /// Makes what touches the active set of a direction.
  void begin_direction();
  /// What the active set adds to the tangent, and to the residual.
  [[nodiscard]] const std::vector<BlockEntry>& tangent();
  void add_targets(NodeVectors& residual) const;
  /// After a direction from r was found with the active set: releases what would pull, adds what
  /// would come in. Returns whether the set is quite another one.
  bool revise(const NodeVectors& r, const NodeVectors& direction);
  /// Leaves those only that touch already.
  void drop_predicted();

  /// Makes the forces of the last `react`, which was at r, the N̂ and T̂. What came to r through a
  /// body gets the tangent plane where it came in as the body's surface, for as long as the stage
  /// lasts. Returns whether there are new planes.
  bool update(const NodeVectors& r);

  /// Nodes with a normal force at the last `react`, ascending, once for each collider.
  [[nodiscard]] std::vector<Index> active_nodes() const;
  /// What its forces change of velocities within the stage that was solved.
  [[nodiscard]] std::vector<ContactImpulse> impulses(const Stage& stage,
                                                     const NodeValues& mass) const;
  /// About how far friction's changes at the last `update` would move nodes: root mean square over
  /// the mass (N) [m].
  [[nodiscard]] double unsettled(const NodeValues& mass) const;
  /// A stage was solved: friction of what came to a collider is no more in the next one, which has
  /// nothing to stop; that of lasting contact it starts from.
  void forget_impacts(const Stage& stage, const NodeValues& mass);

  void save(Memory& memory) const;
  /// Throws InputError where a number cannot be one that was saved.
  void load(const Memory& memory);
  void forget() { friction_.clear(); }

 private:
  struct Normal {
    NodeContact contact;
    double force = 0;       // N
    double penalty = 0;     // κ; 0: not in the active set
    bool is_ahead = false;  // does not touch yet
    [[nodiscard]] std::pair<std::size_t, Index> place() const {
      return {contact.body, contact.node};
    }
  };
  struct Friction {
    Index node = 0;
    std::size_t body = 0;
    Vec3 normal = Vec3::UnitZ();                        // at the last update
    Eigen::Matrix3d sliding = Eigen::Matrix3d::Zero();  // projects on the directions of u_T
    double limit = 0;                                   // μ N̂
    Vec3 kept = Vec3::Zero();                           // T̂
    Vec3 trial = Vec3::Zero();                          // T̂ − κ u_T
    Vec3 force = Vec3::Zero();                          // T
    bool ends = false;                                  // with the stage: it was an impact's
    [[nodiscard]] bool sticks() const { return trial.norm() <= limit; }
    [[nodiscard]] std::pair<std::size_t, Index> place() const { return {body, node}; }
  };
  /// Tangent plane where a node has come into a collider that it would cross.
  struct Plane {
    NodeContact contact;
    double offset = 0;  // [m] normal · position at gap 0
    [[nodiscard]] std::pair<std::size_t, Index> place() const {
      return {contact.body, contact.node};
    }
  };

  /// Positions of the step's end; valid until the next call.
  [[nodiscard]] const NodeVectors& end_of(const NodeVectors& r) const;
  /// Contacts whose gap at positions `end` is less than `within`, by place.
  void find(const NodeVectors& end, double within, std::vector<NodeContact>& found) const;
  [[nodiscard]] Friction friction_of(const NodeContact& c, double force) const;
  [[nodiscard]] Eigen::Matrix3d sliding(Index node, const Vec3& n) const;
  [[nodiscard]] Vec3 slid(const Friction& f, const NodeVectors& r) const;
  [[nodiscard]] Vec3 trial_of(const Friction& f, const NodeVectors& r) const;
  /// Makes f's force that at positions r.
  void act(Friction& f, const NodeVectors& r) const;
  void note_changes(Index nodes);
  void add_ahead();
  void push_out(NodeVectors& r) const;
  void move(Index node, const Vec3& by, NodeVectors& r) const;
  void balance(NodeVectors& residual);
  void load_friction(const std::vector<double>& all, std::size_t nodes);
  bool add_planes(const NodeVectors& end);

  const ColliderContact* contact_ = nullptr;
  const Stage* stage_ = nullptr;
  double touching_ = 0;               // what is nearer touches [m]
  std::vector<Normal> normal_;        // by place
  std::vector<Friction> friction_;    // by place
  std::vector<Plane> planes_;         // by place
  std::vector<NodeVectors> carried_;  // displacements by each body; empty where it stays [m]
  NodeVectors at_;                    // positions of the last `react`
  std::vector<std::pair<std::size_t, Index>> predicted_;  // to touch, in the last direction
  double farthest_ = 0;                                   // that it would move a node [m]
  NodeValues penalty_, friction_penalty_;                 // of each node [N/m]
  NodeValues unsettled_;                                  // (N) of friction at the last update [m]
  // Kept for their memory.
  std::vector<BlockEntry> tangent_;
  std::vector<Normal> ahead_;      // to join normal_
  std::vector<Friction> updated_;  // to join, or to be, friction_
  NodeVectors change_;
  mutable NodeVectors end_;
  mutable std::vector<NodeContact> near_;
};

}  // namespace deform
