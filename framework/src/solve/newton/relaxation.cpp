#include "deform/solve/relaxation.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <vector>

#include <fmt/format.h>

#include "deform/geometry/characteristic_length.h"
#include "deform/log.h"
#include "deform/solve/implicit_stage.h"

#include "solve/contact/contact_law.h"
#include "solve/newton/constants.h"

namespace deform {
namespace {

/// Of the surface's size: how far the first pseudo-step would take it in free fall, how far any
/// shall take it, and how far supports and bodies move in one.
constexpr double kFirstMotion = 0.05, kLargestMotion = 0.2, kSupportMotion = 0.05;
/// Places at which the motion of supports and bodies is looked at.
constexpr int kLooks = 64;
/// Farther than this nothing stops it.
constexpr double kOutOfBounds = 100;
/// Pseudo-steps become longer by these where Newton's method took few iterations, or not many.
constexpr double kMuchLonger = 4, kLonger = 2;
constexpr long kFew = 8, kNotMany = 25;
constexpr double kShorter = 0.25;
/// The longest is so many times the first: inertia is negligible by then.
constexpr double kLongest = 1e6;
/// In a row, each with a shorter pseudo-step; and pseudo-steps of an equilibrium, at most.
constexpr int kMostFailures = 20, kMostSteps = 2000;
/// Part of what is unbalanced that a pseudo-step's own equation may leave.
constexpr double kStageForcing = 0.1, kLoosest = 0.03;

/// Error that a pseudo-step may leave of its solution: the next one goes on from there.
constexpr double kStageError = 1e-3;
/// From there on it is solved as exactly as it takes for friction to balance, too.
constexpr double kNearlyBalanced = 1e-4;

double largest(const NodeVectors& v) { return v.rows() > 0 ? v.rowwise().norm().maxCoeff() : 0; }

}  // namespace

struct Relaxation::Impl {
  explicit Impl(RelaxationSettings s)
      : settings(s), newton({.tolerance = s.tolerance, .iterations = s.iterations}) {}

  void begin(const System& system, const State& state, double end);
  [[nodiscard]] double first_step(const System& system, const State& state) const;
  [[nodiscard]] double next_time() const;
  [[nodiscard]] std::string take(System& system, State& state);
  [[nodiscard]] std::string solve_stage(System& system, double to_time, State& to);
  [[nodiscard]] double residual(const System& system, const State& state) const;
  [[nodiscard]] double scale(const System& system, const State& state) const;
  void adapt(long iterations);
  /// Where nothing moves, forces are balanced that cancel to their rounding.
  [[nodiscard]] bool is_balanced() const {
    return unbalanced <= settings.tolerance ||
           (moved <= kRoundingOfPositions * size && unbalanced <= kRoundingOfForces);
  }

  RelaxationSettings settings;
  ImplicitStage newton;
  Stage stage;
  double end_time = 0;
  double time = 0;  // of supports and bodies
  double first_tau = 0, tau = 0, size = 0;
  double part = 1;                // of kSupportMotion that is tried
  double unbalanced = kInfinity;  // relative to the forces at work
  double moved = kInfinity;       // the farthest node, in the last pseudo-step [m]
  NodeVectors start;
  /// How far supports and bodies have moved by a time, along their paths [m].
  struct Moved {
    double time, length;
  };
  std::vector<Moved> motion;
};

void Relaxation::Impl::begin(const System& system, const State& state, double end) {
  size = characteristic_length(system.rest());
  time = state.time;
  end_time = end;
  part = 1;
  unbalanced = moved = kInfinity;
  start = state.r;
  motion.assign(1, {time, 0});
  NodeVectors last = state.r, next = state.r, carried;
  for (int k = 1; k <= kLooks; ++k) {
    const double from = motion.back().time;
    const double to = k == kLooks ? end : time + (end - time) * k / kLooks;
    system.constraints().prescribe(to, next);
    double length = largest(next - last);
    last = next;
    for (std::size_t b = 0; b < system.contact().bodies(); ++b)
      if (system.contact().carry(b, from, to, state.r, carried))
        length = std::max(length, largest(carried - state.r));
    motion.push_back({to, motion.back().length + length});
  }
}

/// By the accelerations at the beginning.
double Relaxation::Impl::first_step(const System& system, const State& state) const {
  State loaded = state;
  loaded.v.setZero();
  loaded.time = end_time;
  NodeVectors acceleration;
  system.mass_matrix().accelerate(system.evaluator().force(loaded), acceleration);
  const double a = root_mean_square(acceleration, system.mass());
  const double longest = end_time - time;
  return a > 0 ? std::min(std::sqrt(kFirstMotion * size / a), longest) : longest;
}

/// Up to which supports and bodies may go on in the next pseudo-step.
double Relaxation::Impl::next_time() const {
  const auto at = std::ranges::upper_bound(motion, time, {}, &Moved::time);
  if (at == motion.end()) return end_time;
  const Moved& before = *std::prev(at);
  const double done = before.length + (at->length - before.length) * (time - before.time) /
                                          (at->time - before.time);
  const double most = done + part * kSupportMotion * size;
  auto to = at;
  while (std::next(to) != motion.end() && to->length <= most) ++to;
  if (to->length <= most) return end_time;
  const Moved& from = *std::prev(to);
  const double left = std::max(from.length, done), since = std::max(from.time, time);
  return since + (most - left) / (to->length - left) * (to->time - since);
}

/// f(r) + contact, at rest, on what is free [N].
double Relaxation::Impl::residual(const System& system, const State& state) const {
  NodeVectors left = system.evaluator().force(state);
  system.constraints().reduce_force(left);
  const Mobility& mobility = system.contact().mobility();
  for (const ContactImpulse& i : newton.impulses(system, stage)) {
    const Vec3 impulse = i.normal_impulse * i.normal + i.friction_impulse;
    mobility.add(i.node, system.mass()[i.node] / stage.tau * impulse, left);
  }
  return left.norm();
}

/// Of the forces at work at a state: the largest of loads and of single energies' forces [N].
double Relaxation::Impl::scale(const System& system, const State& state) const {
  double largest = system.terms().external_force(state).norm();
  for (std::size_t i = 0; i < system.energies().size(); ++i)
    largest = std::max(largest, system.terms().internal_force(i, state).norm());
  return largest;
}

/// From `to`, a guess; "" or why there is no solution. Friction is then as it was.
std::string Relaxation::Impl::solve_stage(System& system, double to_time, State& to) {
  stage.r_base = stage.start = to.r;
  stage.v_base = NodeVectors::Zero(to.r.rows(), 3);
  stage.tau = tau;
  stage.time = end_time;
  stage.begin = time;
  stage.end = to_time;
  stage.by_strains = true;
  system.constraints().prescribe(to_time, to.r);
  system.constraints().follow_ties(to.r);
  newton.set_limits(std::clamp(kStageForcing * unbalanced, settings.tolerance, kLoosest),
                    unbalanced > kNearlyBalanced ? kStageError : 0);
  Memory friction;
  newton.save(friction);
  std::string reason;
  try {
    reason = newton.solve(system, stage, to);
  } catch (const Error& e) {
    if (e.code() != ExitCode::diverged) throw;
    reason = e.what();
  }
  if (!reason.empty()) newton.load(friction);
  return reason;
}

/// One pseudo-step; "" or why there is none, the state being what it was then.
std::string Relaxation::Impl::take(System& system, State& state) {
  const double to_time = time < end_time ? next_time() : end_time;
  const long before = system.step_report().iterations;
  State to = state;
  std::string reason = solve_stage(system, to_time, to);
  if (!reason.empty()) return reason;
  moved = largest(to.r - state.r);
  state = to;
  state.v.setZero();
  state.time = end_time;
  const double forces = scale(system, state);
  unbalanced = forces > 0 ? residual(system, state) / forces : 0;
  if (time < end_time) unbalanced = std::max(unbalanced, kLoosest);  // supports have just moved
  time = to_time;
  const long iterations = system.step_report().iterations - before;
  log::debug(
      fmt::format("static: a pseudo-step of {:.3g} s took {} iterations, moved {:.3g} m and "
                  "leaves {:.3g} of the forces unbalanced",
                  tau, iterations, moved, unbalanced));
  adapt(iterations);
  return "";
}

void Relaxation::Impl::adapt(long iterations) {
  const double longer = iterations <= kFew ? kMuchLonger : iterations <= kNotMany ? kLonger : 1;
  tau *= std::min(longer, std::sqrt(kLargestMotion * size / std::max(moved, 1e-300)));
  tau = std::min(tau, kLongest * first_tau);
  part = std::min(1.0, part / kShorter);
}

Relaxation::Relaxation(RelaxationSettings settings) : impl_(std::make_unique<Impl>(settings)) {}
Relaxation::~Relaxation() = default;

std::string Relaxation::solve(System& system, double end, State& state) {
  Impl& s = *impl_;
  s.begin(system, state, end);
  s.tau = s.first_tau = s.first_step(system, state);
  StepReport& report = system.step_report();
  int failures = 0;
  report.substeps = 0;
  while (report.substeps + report.rejected < kMostSteps) {
    const std::string reason = s.take(system, state);
    if (!reason.empty()) {
      ++report.rejected;
      if (++failures > kMostFailures) return reason;
      s.tau *= kShorter;
      s.part *= kShorter;
      continue;
    }
    failures = 0;
    ++report.substeps;
    if (largest(state.r - s.start) > kOutOfBounds * s.size)
      return "nothing stops the surface: its loads carry it out of all bounds";
    if (s.time == end && s.is_balanced()) {
      report.contact.clear();
      report.contact.add(system.mass(), s.newton.impulses(system, s.stage), state.v, state.v,
                         s.stage.tau);
      return "";
    }
  }
  return fmt::format("{} pseudo-steps leave {:.3g} of the forces unbalanced", kMostSteps,
                     s.unbalanced);
}

void Relaxation::save(Memory& memory) const { impl_->newton.save(memory); }
void Relaxation::load(const Memory& memory) { impl_->newton.load(memory); }

}  // namespace deform
