/// Directions of descent, which there always are.
#pragma once

#include <functional>
#include <string>

#include "deform/model/tangent.h"
#include "deform/solve/newton_matrix.h"
#include "deform/solve/system.h"
#include "deform/types.h"

namespace deform {

/// Solves (K + diag(d)) p = F with the tangent K that a matrix has; where that is not positive
/// definite with the projected one; where that is not either (a flat sheet without tension does not
/// resist bending in it, loads that follow the surface are in it as they are) with the least
/// multiple of each node's own stiffness added that cures it; at last with nothing but the
/// diagonal. F·p > 0 in the end: a potential whose negative gradient is F falls along p.
class DescentDirection {
 public:
  /// All must live as long. `tolerance`: part of the error that an iterative solver may leave; 0: a
  /// factorisation solves.
  DescentDirection(NewtonMatrix& matrix, const System& system, const NodeVectors& residual,
                   const NodeValues& d, double tolerance)
      : matrix_(&matrix), system_(&system), residual_(&residual), d_(&d), tolerance_(tolerance) {}

  /// `kind`: of K; becomes what the direction is of. `project` makes K the projected tangent.
  /// Returns "" or why there is none: numbers are not finite.
  [[nodiscard]] std::string find(Tangent& kind, const std::function<void()>& project,
                                 NodeVectors& direction);
  [[nodiscard]] long solver_iterations() const { return iterations_; }

 private:
  [[nodiscard]] std::string solve(const NodeValues& d, NodeVectors& direction);
  [[nodiscard]] bool is_descent(const NodeVectors& direction) const;
  void follow_diagonal(const NodeValues& stiffness, NodeVectors& direction) const;

  NewtonMatrix* matrix_;
  const System* system_;
  const NodeVectors* residual_;
  const NodeValues* d_;
  double tolerance_;
  long iterations_ = 0;
};

}  // namespace deform
