/// Preconditioned conjugate gradients for one vector of nodes, in any precision.
#pragma once

#include <numeric>
#include <vector>

#include <deform/parallel.h>

#include "level.h"

namespace multigrid {

/// What an iteration begins with.
enum class From { zero, guess };

struct Ending {
  int iterations = 0;
  bool has_converged = false;
  bool is_indefinite = false;  ///< the matrix, or the preconditioner
};

/// Keeps its vectors from call to call.
template <class Number>
class ConjugateGradients {
 public:
  using Vector = NodeLanes<Number>;

  /// A x = b from a guess x, or from 0, until the residual's norm in the preconditioner has fallen
  /// to `tolerance` of the guess's, which is taken as it is where that is rounding.
  /// multiply(y, first, size, out): A y for some quads; precondition(r, z): z ≈ A⁻¹ r. Sums are
  /// taken in an order that does not depend on threads.
  template <class Multiply, class Precondition>
  Ending solve(const Multiply& multiply, const Precondition& precondition, const Vector& b,
               Vector& x, double tolerance, int most, From from = From::zero) {
    r_ = b;
    q_.resize(b.quads());
    if (from == From::guess) {
      const double rounding = kRounding * kRounding * product(b, b);
      each(b, [&](Index first, Index size) {
        multiply(x, first, size, q_);
        add(Number{-1}, q_.data(), first, first + size, r_.data());
      });
      if (product(r_, r_) <= rounding) return {.has_converged = true};
    } else {
      x.set_zero(b.quads());
    }
    precondition(r_, z_);
    double rz = product(r_, z_);
    const double goal = tolerance * tolerance * rz;
    p_ = z_;
    Ending end{0, rz <= goal, !(rz >= 0)};
    while (!end.has_converged && !end.is_indefinite && end.iterations < most) {
      const double curvature = sum(b, [&](Index first, Index size) {
        multiply(p_, first, size, q_);
        return dot(p_.data(), q_.data(), first, first + size);
      });
      end.is_indefinite = !(curvature > 0);
      if (end.is_indefinite) break;
      const auto alpha = static_cast<Number>(rz / curvature);
      each(b, [&](Index first, Index size) {
        add(alpha, p_.data(), first, first + size, x.data());
        add(-alpha, q_.data(), first, first + size, r_.data());
      });
      ++end.iterations;
      precondition(r_, z_);
      const double next = product(r_, z_);
      end.has_converged = next <= goal;
      end.is_indefinite = !(next >= 0);
      const auto beta = static_cast<Number>(next / rz);
      rz = next;
      each(b, [&](Index first, Index size) {
        scale_and_add(beta, z_.data(), first, first + size, p_.data());
      });
    }
    return end;
  }

 private:
  /// Part of the right-hand side that the residual of a solution may be, for its rounding.
  static constexpr double kRounding = 1e-15;

  template <class Body>
  static void each(const Vector& like, const Body& body) {
    deform::parallel_blocks(like.quads(), kQuads, body);
  }
  template <class Body>
  double sum(const Vector& like, const Body& body) {
    parts_.resize(static_cast<std::size_t>((like.quads() + kQuads - 1) / kQuads));
    each(like, [&](Index first, Index size) {
      parts_[static_cast<std::size_t>(first / kQuads)] = body(first, size);
    });
    return std::accumulate(parts_.begin(), parts_.end(), 0.0);
  }
  double product(const Vector& a, const Vector& b) {
    return sum(
        a, [&](Index first, Index size) { return dot(a.data(), b.data(), first, first + size); });
  }

  Vector r_, z_, p_, q_;
  std::vector<double> parts_;
};

}  // namespace multigrid
