#include "solve/newton/descent_direction.h"

#include <utility>

namespace deform {
namespace {

/// Multiples of the nodes' own stiffness that are tried: the first cures what is singular, the last
/// outweighs what is indefinite.
constexpr double kLeastShift = 1e-10, kLargestShift = 10, kNextShift = 100;

}  // namespace

std::string DescentDirection::solve(const NodeValues& d, NodeVectors& direction) {
  std::string reason;
  if (tolerance_ > 0) {
    reason = matrix_->solve_to(tolerance_, d, *residual_, direction);
    iterations_ += matrix_->solver_iterations();
  } else {
    reason = matrix_->factor(d);
    if (reason.empty()) reason = matrix_->solve(*residual_, direction);
  }
  if (reason.empty() && !is_descent(direction)) reason = "it is no direction of descent";
  return reason;
}

bool DescentDirection::is_descent(const NodeVectors& direction) const {
  return residual_->cwiseProduct(direction).sum() > 0 || residual_->isZero(0);
}

/// F / diagonal on what is free.
void DescentDirection::follow_diagonal(const NodeValues& stiffness, NodeVectors& direction) const {
  const NodeValues diagonal = *d_ + stiffness;
  direction = *residual_;
  const Reduction& reduction = system_->constraints().reduction();
  for (int c = 0; c < 3; ++c)
    for (Index a = 0; a < direction.rows(); ++a)
      direction(a, c) = reduction.free(a, c) ? direction(a, c) / diagonal[a] : 0;
  system_->constraints().follow_ties_of_velocity(direction);
}

std::string DescentDirection::find(Tangent& kind, const std::function<void()>& project,
                                   NodeVectors& direction) {
  std::string reason = solve(*d_, direction);
  if (reason.empty()) return "";
  if (kind != Tangent::projected) {
    kind = Tangent::projected;
    project();
    reason = solve(*d_, direction);
  }
  if (reason.empty()) return "";
  const NodeValues stiffness = matrix_->mean_stiffness().cwiseMax(0);
  for (double shift = kLeastShift; !reason.empty() && shift <= kLargestShift; shift *= kNextShift)
    reason = solve(*d_ + shift * stiffness, direction);
  if (reason.empty()) return "";
  follow_diagonal(stiffness, direction);
  return direction.allFinite() && is_descent(direction) ? "" : reason;
}

}  // namespace deform
