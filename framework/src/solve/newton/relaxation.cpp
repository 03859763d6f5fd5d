#include "deform/solve/relaxation.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "deform/geometry/characteristic_length.h"
#include "deform/log.h"
#include "deform/solve/implicit_stage.h"

namespace deform {
namespace {

/// Of the surface's size: how far the first pseudo-step would take it in free fall, how far any
/// shall take it, and how far supports and bodies move in one.
constexpr double kFirstMotion = 0.05, kLargestMotion = 0.2, kSupportMotion = 0.05;
/// Farther than this nothing stops it.
constexpr double kOutOfBounds = 100;
/// Pseudo-steps become longer by these where Newton's method took few iterations, or not many.
constexpr double kMuchLonger = 4, kLonger = 2;
constexpr long kFew = 8, kNotMany = 25;
constexpr double kShorter = 0.25;
constexpr int kMostFailures = 20;
constexpr int kMostSteps = 2000;
/// Part of what is unbalanced that a pseudo-step's own equation may leave.
constexpr double kForcing = 0.1, kLoosest = 0.03;

double largest(const NodeVectors& v) { return v.rows() > 0 ? v.rowwise().norm().maxCoeff() : 0; }

}  // namespace

struct Relaxation::Impl {
  explicit Impl(RelaxationSettings s)
      : settings(s), newton({.tolerance = s.tolerance, .iterations = s.iterations}) {}

  void begin(const System& system, const State& state, double end);
  [[nodiscard]] double first_step(System& system, const State& state) const;
  [[nodiscard]] double part_of_supports(const System& system, const State& state) const;
  [[nodiscard]] std::string take(System& system, State& state);
  void place_supports(const System& system, double part, State& state) const;
  [[nodiscard]] double scale(const System& system, const State& state) const;
  void adapt(long iterations, double moved);

  RelaxationSettings settings;
  ImplicitStage newton;
  Stage stage;
  double begin_time = 0, end_time = 0;
  double done = 0;  // part of the supports' motion
  double tau = 0, size = 0;
  double unbalanced = kInfinity;  // relative to the forces at work
  bool is_exact = false;          // the last pseudo-step's equation was solved to the tolerance
  NodeVectors start, target;      // of prescribed components
};

void Relaxation::Impl::begin(const System& system, const State& state, double end) {
  size = characteristic_length(system.rest());
  begin_time = state.time;
  end_time = end;
  done = 0;
  unbalanced = kInfinity;
  start = target = state.r;
  system.constraints().prescribe(end, target);
}

/// By the accelerations at the beginning.
double Relaxation::Impl::first_step(System& system, const State& state) const {
  State loaded = state;
  loaded.v.setZero();
  loaded.time = end_time;
  const NodeVectors force = system.evaluator().force(loaded);
  NodeVectors acceleration;
  system.mass_matrix().accelerate(force, acceleration);
  const double a = root_mean_square(acceleration, system.mass());
  const double longest = end_time - begin_time;
  return a > 0 ? std::sqrt(kFirstMotion * size / a) : longest;
}

/// Up to which part supports and bodies may go on in the next pseudo-step.
double Relaxation::Impl::part_of_supports(const System& system, const State& state) const {
  double motion = largest(target - start);
  NodeVectors carried;
  for (std::size_t b = 0; b < system.contact().bodies(); ++b)
    if (system.contact().carry(b, begin_time, end_time, state.r, carried))
      motion = std::max(motion, largest(carried - state.r));
  const double step = motion > 0 ? kSupportMotion * size / motion : 1;
  const double next = done + step;
  return next < 1 - 1e-9 ? next : 1;
}

void Relaxation::Impl::place_supports(const System& system, double part, State& state) const {
  for (int c = 0; c < 3; ++c)
    for (Index a = 0; a < start.rows(); ++a)
      if (system.constraints().reduction().prescribed(a, c))
        state.r(a, c) = start(a, c) + part * (target(a, c) - start(a, c));
  system.constraints().follow_ties(state.r);
}

/// Of the forces at work at a state: the largest of loads and of single energies' forces [N].
double Relaxation::Impl::scale(const System& system, const State& state) const {
  double largest = system.terms().external_force(state).norm();
  for (std::size_t i = 0; i < system.energies().size(); ++i)
    largest = std::max(largest, system.terms().internal_force(i, state).norm());
  return largest;
}

/// One pseudo-step; "" or why there is none, the state being what it was then.
std::string Relaxation::Impl::take(System& system, State& state) {
  const double part = part_of_supports(system, state);
  const auto time_of = [&](double p) {
    return p == 1 ? end_time : begin_time + p * (end_time - begin_time);
  };
  stage.r_base = stage.start = state.r;
  stage.v_base = NodeVectors::Zero(state.r.rows(), 3);
  stage.tau = tau;
  stage.time = end_time;
  stage.begin = time_of(done);
  stage.end = time_of(part);
  stage.by_strains = true;
  State to = state;
  place_supports(system, part, to);
  const double tolerance = std::clamp(kForcing * unbalanced, settings.tolerance, kLoosest);
  newton.set_tolerance(tolerance);
  const long before = system.step_report().iterations;
  std::string reason = newton.solve(system, stage, to);
  if (!reason.empty()) return reason;
  const NodeVectors moved = to.r - state.r;
  to.v.setZero();
  state = to;
  const bool was_whole = done == 1;
  done = part;
  NodeVectors inertia = system.mass().asDiagonal() * moved / (tau * tau);
  system.constraints().reduce_force(inertia);
  const double forces = scale(system, state);
  unbalanced = forces > 0 ? inertia.norm() / forces : 0;
  if (!was_whole) unbalanced = std::max(unbalanced, kLoosest);  // supports have moved just now
  is_exact = tolerance == settings.tolerance;
  const long iterations = system.step_report().iterations - before;
  log::debug(
      fmt::format("static: a pseudo-step of {:.3g} s took {} iterations, moved {:.3g} m and "
                  "leaves {:.3g} of the forces unbalanced",
                  tau, iterations, largest(moved), unbalanced));
  adapt(iterations, largest(moved));
  return "";
}

void Relaxation::Impl::adapt(long iterations, double moved) {
  const double longer = iterations <= kFew ? kMuchLonger : iterations <= kNotMany ? kLonger : 1;
  tau *= std::min(longer, std::sqrt(kLargestMotion * size / std::max(moved, 1e-300)));
}

Relaxation::Relaxation(RelaxationSettings settings) : impl_(std::make_unique<Impl>(settings)) {}
Relaxation::~Relaxation() = default;

std::string Relaxation::solve(System& system, double end, State& state) {
  Impl& s = *impl_;
  s.begin(system, state, end);
  s.tau = s.first_step(system, state);
  StepReport& report = system.step_report();
  int failures = 0;
  report.substeps = 0;
  while (report.substeps + report.rejected < kMostSteps) {
    const std::string reason = s.take(system, state);
    if (!reason.empty()) {
      ++report.rejected;
      if (++failures > kMostFailures) return reason;
      s.tau *= kShorter;
      continue;
    }
    failures = 0;
    ++report.substeps;
    if (largest(state.r - s.start) > kOutOfBounds * s.size)
      return "nothing stops the surface: its loads carry it out of all bounds";
    if (s.done == 1 && s.is_exact && s.unbalanced <= s.settings.tolerance) {
      state.time = end;
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
