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

/// Keeps its vectors from call to call. `Lane` has +=, −=, a product with a number of type `Real`,
/// and a `dot` in double precision.
template <class Lane, class Real>
class ConjugateGradients {
 public:
  using Vector = std::vector<Lane>;

  /// A x = b from a guess x, or from 0, until the residual's norm in the preconditioner has fallen
  /// to `tolerance` of b's. row_times(a, y): (A y)_a; precondition(r, z): z ≈ A⁻¹ r. Sums are taken
  /// in an order that does not depend on threads.
  template <class RowTimes, class Precondition>
  Ending solve(const RowTimes& row_times, const Precondition& precondition, const Vector& b,
               Vector& x, double tolerance, int most, From from = From::zero) {
    const auto n = static_cast<Index>(b.size());
    r_ = b;
    q_.resize(b.size());
    precondition(r_, z_);
    double rz = product(r_, z_);
    const double goal = tolerance * tolerance * rz;
    if (from == From::guess) {
      each(n, [&](std::size_t a) { r_[a] -= row_times(static_cast<Index>(a), x); });
      precondition(r_, z_);
      rz = product(r_, z_);
    } else {
      x.assign(b.size(), {});
    }
    p_ = z_;
    Ending end{0, rz <= goal, !(rz >= 0)};
    while (!end.has_converged && !end.is_indefinite && end.iterations < most) {
      const double curvature = sum(n, [&](std::size_t a) {
        q_[a] = row_times(static_cast<Index>(a), p_);
        return dot(p_[a], q_[a]);
      });
      end.is_indefinite = !(curvature > 0);
      if (end.is_indefinite) break;
      const auto alpha = static_cast<Real>(rz / curvature);
      each(n, [&](std::size_t a) { x[a] += alpha * p_[a], r_[a] -= alpha * q_[a]; });
      ++end.iterations;
      precondition(r_, z_);
      const double next = product(r_, z_);
      end.has_converged = next <= goal;
      end.is_indefinite = !(next >= 0);
      const auto beta = static_cast<Real>(next / rz);
      rz = next;
      each(n, [&](std::size_t a) { p_[a] = z_[a] + beta * p_[a]; });
    }
    return end;
  }

 private:
  template <class Body>
  static void each(Index n, const Body& body) {
    deform::parallel_blocks(n, kRows, [&](Index first, Index size) {
      for (Index a = first; a < first + size; ++a) body(static_cast<std::size_t>(a));
    });
  }
  template <class Body>
  double sum(Index n, const Body& body) {
    parts_.resize(static_cast<std::size_t>((n + kRows - 1) / kRows));
    deform::parallel_blocks(n, kRows, [&](Index first, Index size) {
      double part = 0;
      for (Index a = first; a < first + size; ++a) part += body(static_cast<std::size_t>(a));
      parts_[static_cast<std::size_t>(first / kRows)] = part;
    });
    return std::accumulate(parts_.begin(), parts_.end(), 0.0);
  }
  double product(const Vector& a, const Vector& b) {
    return sum(static_cast<Index>(a.size()), [&](std::size_t i) { return dot(a[i], b[i]); });
  }

  Vector r_, z_, p_, q_;
  std::vector<double> parts_;
};

}  // namespace multigrid
