/// Preconditioned conjugate gradients for one vector of nodes, in single precision.
#pragma once

#include <algorithm>

#include <deform/parallel.h>

#include "field.h"
#include "field_kernels.h"

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
  void assign(Index nodes, Index stride) {
    p_.assign(nodes, stride);
    q_.assign(nodes, stride);
  }

  /// Adds to x, in its precision, what takes its residual r away; what is left of that is in r
  /// then. multiply(p, q): q = A p, returns p·q; precondition(): z ≈ A⁻¹ r, returns r·z. Both sum
  /// in an order that does not depend on threads.
  template <class Multiply, class Precondition, class Number>
  Ending solve(const Multiply& multiply, const Precondition& precondition, Field<float>& r,
               const Field<float>& z, Field<Number>& x, Goal goal, int most) {
    double rz = precondition();
    const double enough = std::max(goal.part * goal.part * rz, goal.absolute);
    Ending end{0, rz <= enough, !(rz >= 0), rz, rz};
    if (!end.has_converged) p_ = z;
    while (!end.has_converged && !end.is_indefinite && end.iterations < most) {
      const double curvature = multiply(p_, q_);
      end.is_indefinite = !(curvature > 0);
      if (end.is_indefinite) break;
      const auto alpha = static_cast<float>(rz / curvature);
      each_part([&](Index c, Index first, Index size) {
        add(size, alpha, p_.data(c) + first, x.data(c) + first);
        add(size, -alpha, q_.data(c) + first, r.data(c) + first);
      });
      ++end.iterations;
      const double next = precondition();
      end.has_converged = next <= enough;
      end.is_indefinite = !(next >= 0);
      const auto beta = static_cast<float>(next / rz);
      rz = end.last = next;
      if (end.has_converged) break;
      each_part([&](Index c, Index first, Index size) {
        scale_and_add(size, beta, z.data(c) + first, p_.data(c) + first);
      });
    }
    return end;
  }

 private:
  template <class Body>
  void each_part(const Body& body) const {
    constexpr Index kNodes = 4096;
    deform::parallel_blocks(p_.nodes(), kNodes, [&](Index first, Index size) {
      for (Index c = 0; c < 3; ++c) body(c, first, size);
    });
  }

  Field<float> p_, q_;
};

}  // namespace multigrid
