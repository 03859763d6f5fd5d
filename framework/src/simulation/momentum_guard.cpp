#include "simulation/momentum_guard.h"

#include <algorithm>

#include <fmt/format.h>

#include "deform/geometry/characteristic_length.h"
#include "deform/log.h"
#include "deform/record/loads_at.h"

#include "solve/asked.h"

namespace deform {
namespace {

/// Part of the impulses' sizes by which momentum may differ from their sum.
constexpr double kMost = 0.1;
/// Part of the nodes' momenta by which what solvers leave may change their sum.
constexpr double kLeft = 1e-4;

bool has_own_impulses(const System& system) {
  const Reduction& reduction = system.constraints().reduction();
  for (int c = 0; c < 3; ++c)
    for (Index a = 0; a < system.nodes(); ++a)
      if (!reduction.free(a, c)) return true;
  return system.contact().bodies() > 0;
}

Vec3 momentum(const System& system, const NodeVectors& v) {
  return v.topRows(system.nodes()).transpose() * system.mass().head(system.nodes());
}

double momenta(const System& system, const NodeVectors& v) {
  return v.topRows(system.nodes()).rowwise().norm().dot(system.mass().head(system.nodes()));
}

}  // namespace

MomentumGuard::MomentumGuard(const System& system, const Named<Integrator>& integrator)
    : is_known_(!is_static(integrator) && !has_own_impulses(system)) {}

bool MomentumGuard::watches(long steps) const { return is_known_ && !warned_ && is_guarded(steps); }

MomentumGuard::Sum MomentumGuard::sum(const Frame& frame, NodeVectors loads) {
  loads += frame.system.evaluator().damping_force(frame.state);
  const auto of_nodes = loads.topRows(frame.system.nodes());
  return {.vector = of_nodes.colwise().sum().transpose(), .sizes = of_nodes.rowwise().norm().sum()};
}

/// A term that holds the surface to places in space pulls where all of it is moved.
bool MomentumGuard::has_internal_net_force(const Frame& frame) {
  constexpr double kTolerance = 1e-6;
  State moved = frame.state;
  auto r = moved.r.topRows(frame.system.nodes());
  r.rowwise() += Eigen::RowVector3d(0.3, 0.5, 0.7) * characteristic_length(frame.positions());
  for (std::size_t i = 0; i < frame.system.energies().size(); ++i) {
    const NodeVectors f =
        frame.system.terms().internal_force(i, moved).topRows(frame.system.nodes());
    if (f.colwise().sum().norm() > kTolerance * f.rowwise().norm().sum()) return true;
  }
  return false;
}

void MomentumGuard::begin(const Frame& frame) {
  counted_ = 0;
  if (frame.step == last_) return;
  if (!is_checked_) {
    is_checked_ = true;
    is_known_ = !has_internal_net_force(frame);
  }
  in_a_row_ = 0;
  first_ = momentum(frame.system, frame.state.v);
  largest_ = momenta(frame.system, frame.state.v);
  least_ = most_ = Vec3::Zero();
  sizes_ = 0;
  force_ = sum(frame, loads_at(frame, frame.step_size).after);
}

void MomentumGuard::add_part(const Frame& frame, double length) {
  LoadsAt loads = loads_at(frame, length);
  const Sum now = sum(frame, std::move(loads.before));
  least_ += length * force_.vector.cwiseMin(now.vector);
  most_ += length * force_.vector.cwiseMax(now.vector);
  sizes_ += length * 0.5 * (force_.sizes + now.sizes);
  force_ = sum(frame, std::move(loads.after));
}

void MomentumGuard::at_break(const Frame& frame) {
  add_part(frame, frame.step_size);
  counted_ += frame.step_size;
}

void MomentumGuard::end(const Frame& frame) {
  add_part(frame, frame.step_size - counted_);
  last_ = frame.step;
  largest_ = std::max(largest_, momenta(frame.system, frame.state.v));
  if (++in_a_row_ < kGuardedInARow) return;
  const Vec3 gained = momentum(frame.system, frame.state.v) - first_;
  const Vec3 impulse = gained.cwiseMax(least_).cwiseMin(most_);  // the nearest that forces allow
  if ((gained - impulse).norm() > kMost * sizes_ + kLeft * largest_) warn(frame, gained, impulse);
}

void MomentumGuard::warn(const Frame& frame, const Vec3& gained, const Vec3& impulse) {
  warned_ = true;
  log::warn(fmt::format(
      "momentum changes by what is not the impulse of the forces: by ({:.3g}, {:.3g}, {:.3g}) "
      "kg·m/s over the {} steps up to step {}, where forces give ({:.3g}, {:.3g}, {:.3g}). The "
      "integrator is wrong, or loads change faster than its steps: try a shorter "
      "/integrator/step; the probe momentum shows it",
      gained[0], gained[1], gained[2], kGuardedInARow, frame.step, impulse[0], impulse[1],
      impulse[2]));
}

}  // namespace deform
