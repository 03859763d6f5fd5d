/// Flexible GMRES: linear equations of which only products are known.
#pragma once

#include <functional>
#include <vector>

#include "deform/types.h"

namespace deform {

/// What a solution takes.
struct KrylovLimits {
  double tolerance = 0.02;  ///< of |b − A x|, relative to |b|
  int vectors = 20;         ///< of the Krylov space, at most
};

struct KrylovSolution {
  int vectors = 0;      ///< of the Krylov space; 0: none was found
  double residual = 1;  ///< |b − A x|, relative to |b|
};

/// Solves A x = b for an unsymmetric A by GMRES with a preconditioner P from the right, which may
/// be another one at each iteration (an iterative solver, say): flexible GMRES (Saad 1993). For
/// each vector of the Krylov space it takes one product with A and, but for the first, one with
/// P⁻¹.
class FlexibleGmres {
 public:
  /// Makes `out` (N × 3) of `in` (N × 3); false where it cannot.
  using Operator = std::function<bool(const NodeVectors& in, NodeVectors& out)>;

  /// `inverse_p`: P⁻¹. `x`: P⁻¹ b, becomes the solution, or the best that the Krylov space has.
  /// Where an operator cannot or a product is not finite, there is none, and x remains P⁻¹ b.
  [[nodiscard]] KrylovSolution solve(const Operator& a, const Operator& inverse_p,
                                     const NodeVectors& b, const KrylovLimits& limits,
                                     NodeVectors& x);

 private:
  // Kept for their memory: the Krylov space, its vectors preconditioned, a product.
  std::vector<NodeVectors> v_, z_;
  NodeVectors w_;
};

}  // namespace deform
