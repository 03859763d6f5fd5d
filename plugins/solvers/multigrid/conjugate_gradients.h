/// Preconditioned conjugate gradients for one vector of nodes, in single precision.
#pragma once

#include <algorithm>
#include <vector>

#include "level.h"

namespace multigrid {

/// What r·z is reduced to, the square of the residual's norm in the preconditioner: to `part²` of
/// what it is at first, or to `absolute`, whichever comes first.
struct Goal {
  double part = 0, absolute = 0;
};

struct Ending {
  int iterations = 0;
  bool has_converged = false;
  bool is_indefinite = false;  ///< the matrix, or the preconditioner
  double first = 0, last = 0;  ///< r·z
};

/// Keeps its vectors from call to call.
class ConjugateGradients {
 public:
  /// Adds to x, in its precision, what takes its residual r away; what is left of that is in r
  /// then. multiply(y, first, size, out): A y for some quads; precondition(): z ≈ A⁻¹ r, returns
  /// r·z. Sums are taken in an order that does not depend on threads.
  template <class Multiply, class Precondition, class Vector>
  Ending solve(const Multiply& multiply, const Precondition& precondition, LaneVector& r,
               const LaneVector& z, Vector& x, Goal goal, int most) {
    q_.resize(r.quads());
    double rz = precondition();
    const double enough = std::max(goal.part * goal.part * rz, goal.absolute);
    Ending end{0, rz <= enough, !(rz >= 0), rz, rz};
    if (!end.has_converged) p_ = z;
    while (!end.has_converged && !end.is_indefinite && end.iterations < most) {
      const double curvature = sums_(r.quads(), [&](Index first, Index size) {
        multiply(p_, first, size, q_);
        return dot(p_.data(), q_.data(), first, first + size);
      });
      end.is_indefinite = !(curvature > 0);
      if (end.is_indefinite) break;
      const auto alpha = static_cast<float>(rz / curvature);
      deform::parallel_blocks(r.quads(), kQuads, [&](Index first, Index size) {
        add(alpha, p_.data(), first, first + size, x.data());
        add(-alpha, q_.data(), first, first + size, r.data());
      });
      ++end.iterations;
      const double next = precondition();
      end.has_converged = next <= enough;
      end.is_indefinite = !(next >= 0);
      const auto beta = static_cast<float>(next / rz);
      rz = end.last = next;
      if (end.has_converged) break;
      deform::parallel_blocks(r.quads(), kQuads, [&](Index first, Index size) {
        scale_and_add(beta, z.data(), first, first + size, p_.data());
      });
    }
    return end;
  }

 private:
  LaneVector p_, q_;
  Sums sums_;
};

}  // namespace multigrid
