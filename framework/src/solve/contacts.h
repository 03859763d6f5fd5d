/// Contact of a surface's nodes with the colliders of its scene.
#pragma once

#include <vector>

#include "deform/solve/system.h"

namespace deform {

/// Keeps nodes outside of bodies. A step that ends with a node inside is amended: the node goes to
/// the nearest point of the body, and what it moved along the body's surface within the step is
/// shortened by at most friction × how far it was pushed. That is Coulomb's law: for a node at rest
/// on the body the push of a step is its acceleration into the body times step², and so is what it
/// would slide. Its velocity is then that of the amended motion: contact is inelastic.
///
/// Nodes with a prescribed component are not amended: they are where the scene wants them.
class Contacts {
 public:
  Contacts(std::vector<Body> bodies, bool mirrored, const Reduction& reduction);

  [[nodiscard]] bool none() const { return bodies_.empty(); }
  /// Amends `after`, which a step of so many seconds made of `before` (N × 3).
  void resolve(const NodeVectors& before, double step, State& after);
  /// Free nodes nearer to a body than its thickness and `within`, were they at r (N × 3).
  void find(double time, const NodeVectors& r, double within,
            std::vector<NodeContact>& found) const;
  /// (M) Distance of points (M × 3) to the nearest body at a time, negative inside [m]; infinite
  /// where there is no body.
  [[nodiscard]] NodeValues clearance(double time, const NodeVectors& points) const;
  /// The free node that is deepest inside of a body, thickness included; throws InputError naming
  /// it when it is deeper than `slack` [m].
  void require_outside(const NodeVectors& r, double slack) const;

 private:
  /// Distances of points to one body and the normals there; refuses what is not finite.
  void measure(const Body& body, double time, const NodeVectors& points, NodeValues& distance,
               NodeVectors& normal) const;
  /// Returns whether any node was inside.
  bool resolve(const Body& body, const NodeVectors& before, double step, State& after);

  std::vector<Body> bodies_;
  bool mirrored_;
  std::vector<char> free_;  // whether all components of a node are
  NodeValues distance_;     // of all nodes to one body
  NodeVectors normal_;
};

}  // namespace deform
