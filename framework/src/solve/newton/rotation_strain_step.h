/// Steps along a direction that turn parts of the surface instead of stretching them.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "deform/solve/block_matrix.h"
#include "deform/surface/surface.h"

#include "solve/matrix/tangent_solver.h"

namespace deform {

/// A straight step r + s d along a direction that turns the surface by an angle θ stretches it by
/// θ²/2, which a thin sheet resists so much that a search along straight lines hardly moves. A
/// rotation–strain step splits the change d_b − d_a of each link e = r_b − r_a (two corners of a
/// face) into the turn ω × e of its neighbourhood and the rest η, and takes the links to R(s ω)(e +
/// s η), R: a rotation by a finite angle; positions fit these best. To first order in s both steps
/// are the same. (Rotation–strain coordinates; Huang et al. 2011, for displacements between modes.)
class RotationStrainStep {
 public:
  struct Link {
    Index a, b;     ///< a < b
    double weight;  ///< 1/|e|² at rest [1/m²]
  };

  /// `map` may know of more unknowns than nodes: these go straight.
  RotationStrainStep(const Surface& surface, const NodeVectors& rest, const ReductionMap& map,
                     const std::vector<Freedom>& held, const SolverSource& solvers);

  /// Takes a direction d at r (both N × 3). Returns the largest angle by which it turns [rad].
  double begin(const NodeVectors& r, const NodeVectors& d);
  /// Positions after s times that direction; r + s d where none can be fitted.
  void at(double s, NodeVectors& r);

 private:
  [[nodiscard]] bool factorise();
  [[nodiscard]] bool prepare();
  [[nodiscard]] std::string solve();
  [[nodiscard]] bool fit();
  void find_floating(const NodeVectors& rest);
  void take_means_away(NodeVectors& field) const;

  /// A component of nodes that links join, none of which is held in it: adding a constant to it
  /// changes no link, so the fit is unique but for that. Found for iterative solvers.
  struct Floating {
    int component;
    std::vector<Index> nodes;
  };
  std::vector<Link> links_;
  BlockMatrix laplacian_;
  TangentSolver solver_;
  std::vector<Floating> floating_;
  double mean_ = 0;  // of the Laplacian's diagonal [1/m²]
  bool is_prepared_ = false, is_factorised_ = false;
  NodeVectors from_, direction_, rotation_;  // (N × 3) [m], [m], [rad]
  // Kept for their memory.
  std::vector<Eigen::Matrix3d> normal_;  // (N) [1], normal equations of the turns
  NodeVectors pull_, correction_;        // (N × 3) [1/m], [m], of the positions
};

}  // namespace deform
