/// Contact of a surface's nodes with the colliders of its scene.
#pragma once

#include <vector>

#include "deform/solve/system.h"

#include "solve/contact_law.h"
#include "solve/contact_paths.h"

namespace deform {

/// Keeps nodes outside of bodies. A step that ends with a node inside is amended: the node goes to
/// the nearest point of the body, and what it moved along the body's surface within the step is
/// shortened by at most friction × how far it was pushed. That is Coulomb's law: what the body's
/// push changes of the way along the normal, friction changes by at most so many times that of the
/// way across. For the velocity the same law holds by itself, whichever way a method makes
/// positions of velocities: contact is inelastic.
///
/// A node whose way through the step leads into a body on another side than the one where it is
/// nearest to the surface in the end, or right through a part of it, is stopped where it came in.
///
/// Nodes move as far as constraints leave them free; those that are held along a body's normal
/// pass: they are where the scene wants them.
class Contacts {
 public:
  /// `map` must live as long.
  Contacts(std::vector<Body> bodies, const ReductionMap& map);

  /// Amends `after`, which a step of so many seconds made of `before` (N × 3). Returns the nodes
  /// that it amended, ascending.
  std::vector<Index> resolve(const NodeVectors& before, double step, State& after);
  /// As System::find_contacts.
  void find(double time, const NodeVectors& from, const NodeVectors& r, double within,
            std::vector<NodeContact>& found) const;
  /// As System::settle.
  void settle(double step, const std::vector<ContactImpulse>& impulses, State& state) const;
  /// (M) Distance of points (M × 3) to the nearest body at a time, negative inside [m]; infinite
  /// where there is no body.
  [[nodiscard]] NodeValues clearance(double time, const NodeVectors& points) const;
  /// The movable node that is deepest inside of a body, thickness included; throws InputError
  /// naming it when it is deeper than `slack` [m].
  void require_outside(const NodeVectors& r, double slack) const;

 private:
  /// Distances of points to one body and the normals there; refuses what is not finite.
  void measure(const Body& body, double time, const NodeVectors& points, NodeValues& distance,
               NodeVectors& normal) const;
  /// Of ways from → to, at whose ends distances and normals are known: where those come in that
  /// have crossed the body, or its side. The body is where it is at that time.
  [[nodiscard]] std::vector<EntryPlane> crossings(const Body& body, double time,
                                                  const NodeVectors& from, const NodeVectors& to,
                                                  const NodeValues& distance,
                                                  const NodeVectors& normal) const;
  /// Whether a way may lead through a body that its end is `gap` away from.
  [[nodiscard]] bool may_cross(const Body& body, Index node, const Vec3& from, const Vec3& to,
                               double gap, const Vec3& normal) const;
  /// Gap and normal of each movable node, in turn, that is nearer to a body than `within`.
  template <class Visit>
  void visit_near(const Body& body, double time, const NodeVectors& from, const NodeVectors& r,
                  double within, const Visit& visit) const;
  /// Returns which nodes were inside.
  std::vector<Index> resolve(std::size_t body, const NodeVectors& before, double step,
                             State& after);
  /// How fast each impulse's body has moved along the normal there [m/s].
  [[nodiscard]] std::vector<double> speeds(double step, const std::vector<ContactImpulse>& impulses,
                                           const State& state) const;

  std::vector<Body> bodies_;
  std::vector<bool> is_convex_;
  Mobility mobility_;
};

}  // namespace deform
