#include "deform/solve/stepped_integrator.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <limits>

#include <fmt/format.h>

#include "deform/geometry/characteristic_length.h"
#include "deform/log.h"

#include "solve/stepping/headway.h"

namespace deform {
namespace {

/// A step is shortened this often before the run is given up.
constexpr int kMostHalvings = 10;
/// So many steps must succeed before twice as long ones are tried.
constexpr int kBeforeLonger = 4;
/// What is left of a scene's step counts as nothing below this part of it.
constexpr double kRoundingOfTime = 1e-9;
/// With error control: part of the first step that is tried first, how far below the error allowed
/// steps are aimed, and how much one may differ from the one before.
constexpr double kFirst = 0.1, kSafety = 0.9, kLeastChange = 0.2, kMostChange = 2;
/// With error control a step of the scene is given up that is not done after so many tries …
constexpr long kMostTries = 1000000;
/// … or that would take parts below this part of it.
constexpr double kShortestPart = 1e-12;
/// Errors below so many roundings of the largest coordinate cannot be told from rounding.
constexpr double kLeastError = 64 * std::numeric_limits<double>::epsilon();

double size_of(const System& system) { return characteristic_length(system.rest()); }

std::vector<double> flattened(const NodeVectors& v) { return {v.data(), v.data() + v.size()}; }

NodeVectors vectors_of(const Memory& memory, const std::string& name) {
  const auto entry = memory.entries().find(name);
  if (entry == memory.entries().end() || entry->second.size() % 3 != 0)
    throw InputError("the checkpoint has no \"" + name + "\", or not three numbers a node");
  return Eigen::Map<const NodeVectors>(entry->second.data(),
                                       static_cast<Index>(entry->second.size() / 3), 3);
}

}  // namespace

SteppedIntegrator::SteppedIntegrator(StepControl control)
    : control_(control), headway_(std::make_unique<Headway>()) {
  if (control.error > 0 && control.error < kLeastError)
    throw InputError(
        fmt::format("'error' is {:g}, expected 0 or at least {:.2g}: less than that is "
                    "rounding of positions, whatever the step",
                    control.error, kLeastError));
}
SteppedIntegrator::~SteppedIntegrator() = default;
void SteppedIntegrator::accept(const State& /*from*/, const State& /*to*/) {}
void SteppedIntegrator::forget() {}

void SteppedIntegrator::put(Memory& memory, const std::string& name, const State& state) {
  memory.put(name + ".r", flattened(state.r));
  memory.put(name + ".v", flattened(state.v));
  memory.put(name + ".time", {state.time});
}

bool SteppedIntegrator::has(const Memory& memory, const std::string& name) {
  return memory.entries().contains(name + ".time");
}

State SteppedIntegrator::get(const Memory& memory, const std::string& name) {
  State state{vectors_of(memory, name + ".r"), vectors_of(memory, name + ".v"),
              memory.get(name + ".time", 1).front()};
  if (state.r.rows() != state.v.rows())
    throw InputError("the checkpoint's \"" + name +
                     "\" has positions and velocities of different numbers of nodes");
  if (!state.r.allFinite() || !state.v.allFinite() || !std::isfinite(state.time))
    throw InputError("the checkpoint's \"" + name + "\" is not finite");
  return state;
}

bool SteppedIntegrator::goes_on_from(const State& state) const {
  return last_.r.rows() == state.r.rows() && last_.r == state.r && last_.v == state.v;
}

void SteppedIntegrator::advance(System& system, State& state, double step) {
  if (!goes_on_from(state)) {
    forget();
    left_ = right_ = State{};
    next_ = 0;
  }
  StepReport& report = system.step_report();
  if (report.largest == 0) report.substeps = report.rejected = 0;  // the scene's step begins
  halvings_ = 0;
  headway_->begin(step);
  if (control_.error > 0) {
    advance_adaptive(system, state, step);
  } else {
    advance_fixed(system, state, step);
  }
  headway_->end();
  last_ = state;
}

double SteppedIntegrator::within_step(double time, double begin, double step) {
  const double end = begin + step;
  const double margin =
      std::max(kRoundingOfTime * step, 4 * std::numeric_limits<double>::epsilon() * std::abs(end));
  return std::min(std::max(time, begin + margin), end - margin);
}

void SteppedIntegrator::advance_fixed(System& system, State& state, double step) {
  const double end = state.time + step;
  const double begin = state.time;
  double part = step, done = 0;
  int taken = 0;  // since the last failure
  while (done < step) {
    double h = std::min({part, step - done, system.longest_step(state.time)});
    if (step - done - h < kRoundingOfTime * step) h = step - done;
    const Attempt attempt = try_step(system, state, h, to_);
    headway_->tried(attempt.failure.empty() ? done + h : done, attempt.failure);
    if (!attempt.failure.empty()) {
      ++system.step_report().rejected;
      part = h;
      taken = 0;
      shorten(part, longest_, attempt.failure);
      continue;
    }
    accept(state, to_);
    count(system, state, to_, h, attempt);
    halvings_ = 0;
    done = h == step - done ? step : done + h;
    std::swap(state, to_);
    state.time = done == step ? end : begin + done;
    if (++taken % kBeforeLonger == 0) part = std::min(2 * part, step);
  }
}

/// The smallest error that can be asked for depends on where the surface is.
void SteppedIntegrator::require_representable_error(const System& system,
                                                    const State& state) const {
  const double least = kLeastError * state.r.cwiseAbs().maxCoeff() / size_of(system);
  if (control_.error < least)
    throw Error(
        ExitCode::diverged,
        fmt::format("the error allowed, {:g} characteristic lengths, is below the rounding of "
                    "positions so far from the origin: {:.2g} at least",
                    control_.error, least));
}

/// Ends what would go on for ever.
void SteppedIntegrator::require_headway(double h, double step) const {
  const bool is_short = !(h > kShortestPart * step) || !(right_.time + h > right_.time);
  if (!is_short && headway_->tries() < kMostTries) return;
  throw Error(
      ExitCode::diverged,
      fmt::format("no step is short enough for the error allowed ({:g} characteristic lengths): "
                  "{:.3g} s of {:.3g} s came out of {} tries, the next is one of {:.3g} s. A "
                  "larger 'error', a stiffer method or a shorter 'step' may do",
                  control_.error, std::max(0.0, headway_->gained()), step, headway_->tries(), h));
}

void SteppedIntegrator::advance_adaptive(System& system, State& state, double step) {
  if (right_.r.size() == 0) {
    require_representable_error(system, state);
    left_ = right_ = state;
    next_ = kFirst * std::min(step, control_.largest_step);
  }
  const double begin = state.time, end = begin + step;
  while (right_.time < end - kRoundingOfTime * step) {
    const double from = right_.time;
    const double breaks = system.next_break(from + kRoundingOfTime * step);
    const double h =
        std::min({next_, control_.largest_step, system.longest_step(from), breaks - from});
    require_headway(h, step);
    const Attempt attempt = try_step(system, right_, h, to_);
    const bool is_known = attempt.error.size() > 0;
    const double error = is_known ? error_of(system, attempt.error) / control_.error : 1;
    if (!attempt.failure.empty()) {
      ++system.step_report().rejected;
      next_ = h;
      headway_->tried(from - begin, attempt.failure);
      shorten(next_, longest_, attempt.failure);
      continue;
    }
    const double wanted = error > 0 ? kSafety * std::pow(error, -1.0 / local_order()) : kMostChange;
    if (is_known && error > 1) {
      ++system.step_report().rejected;
      next_ = h * std::clamp(wanted, kLeastChange, 1.0);
      headway_->tried(from - begin, fmt::format("the error is {:.3g} of that allowed", error));
      continue;
    }
    accept(right_, to_);
    count(system, right_, to_, h, attempt);
    halvings_ = 0;
    // A step that was cut for a part of the model says nothing against the longer one.
    next_ = std::max(h < next_ ? next_ : 0.0,
                     h * (is_known ? std::clamp(wanted, kLeastChange, kMostChange) : 1));
    std::swap(left_, right_);
    std::swap(right_, to_);
    if (h == breaks - from) right_.time = breaks;  // to the last bit
    headway_->tried(right_.time - begin, "");
  }
  interpolate(system, end, state);
  // A polynomial knows of no impact: what it takes into a collider is put on its surface.
  if (system.contact().bodies() > 0 && end > left_.time)
    (void)system.contact().resolve(left_, end - left_.time, state);
}

SteppedIntegrator::Attempt SteppedIntegrator::try_step(System& system, const State& from,
                                                       double step, State& to) {
  Attempt result;
  cause_ = nullptr;
  longest_ = 0;
  to = from;
  try {
    result = attempt(system, from, step, to);
    if (result.failure.empty() && !result.resolved_contacts)
      result.contact = system.contact().resolve(from, step, to);
    const bool is_finite = to.r.allFinite() && to.v.allFinite();
    if (result.failure.empty() && !is_finite) result.failure = "the state is not finite";
  } catch (const StepTooLong& e) {
    result.failure = e.what();
    longest_ = e.longest();
    cause_ = std::current_exception();
  } catch (const Error& e) {
    if (e.code() != ExitCode::diverged) throw;
    result.failure = e.what();
    cause_ = std::current_exception();
  }
  return result;
}

/// Half the step, or the one `wanted` if that is shorter.
void SteppedIntegrator::shorten(double& step, double wanted, const std::string& why) {
  if (++halvings_ > kMostHalvings) {
    if (cause_) std::rethrow_exception(cause_);
    throw Error(ExitCode::diverged,
                fmt::format("no step is short enough, {:.3g} s neither: {}", step, why));
  }
  const double shorter = wanted > 0 && wanted < step ? wanted : step / 2;
  log::info(fmt::format("a step of {:.3g} s fails ({}): {:.3g} s is tried", step, why, shorter));
  step = shorter;
}

void SteppedIntegrator::count(System& system, const State& from, const State& to, double step,
                              const Attempt& attempt) {
  StepReport& report = system.step_report();
  if (system.contact().bodies() > 0)
    report.contact.add(system.mass(), attempt.contact, from.v, to.v, step);
  report.smallest = report.substeps == 0 ? step : std::min(report.smallest, step);
  report.largest = std::max(report.largest, step);
  ++report.substeps;
}

/// What is prescribed has no error, though an estimate may see its velocity jump.
double SteppedIntegrator::error_of(const System& system, NodeVectors error) {
  for (int c = 0; c < 3; ++c)
    for (Index a = 0; a < error.rows(); ++a)
      if (system.constraints().reduction().prescribed(a, c)) error(a, c) = 0;
  return root_mean_square(error, system.mass()) / size_of(system);
}

/// The cubic Hermite polynomial of r at both ends of the last step, and its derivative, or what is
/// linear between both velocities (is_of_first_order).
void SteppedIntegrator::interpolate(const System& system, double time, State& state) const {
  const double h = right_.time - left_.time;
  const double s = h > 0 ? (time - left_.time) / h : 1;
  const double a = s * s * (3 - 2 * s), b = s * (1 - s) * (1 - s), c = s * s * (s - 1);
  state.r = (1 - a) * left_.r + a * right_.r + h * (b * left_.v + c * right_.v);
  const double da = 6 * s * (1 - s), db = (1 - s) * (1 - 3 * s), dc = s * (3 * s - 2);
  if (!(h > 0))
    state.v = right_.v;
  else if (is_of_first_order())
    state.v = (1 - s) * left_.v + s * right_.v;
  else
    state.v = da / h * (right_.r - left_.r) + db * left_.v + dc * right_.v;
  state.time = time;
  system.constraints().prescribe(time, state.r);
  if (h > 0) system.constraints().prescribe_velocity(time, s > 0.5 ? h : -h, state.v);
}

void SteppedIntegrator::save(Memory& memory) const {
  if (last_.r.size() == 0) return;
  put(memory, "last", last_);
  memory.put("next_step", {next_});
  if (right_.r.size() == 0) return;
  put(memory, "left", left_);
  put(memory, "right", right_);
}

void SteppedIntegrator::load(const Memory& memory) {
  if (!has(memory, "last")) return;
  last_ = get(memory, "last");
  next_ = memory.get("next_step", 1).front();
  if (!(next_ >= 0) || !std::isfinite(next_))
    throw InputError("the checkpoint's \"next_step\" is no length of a step");
  if (!has(memory, "right")) return;
  left_ = get(memory, "left");
  right_ = get(memory, "right");
  require_last_step();
}

/// Steps of its own end at the scene's last one or beyond, the rounding of times aside: one that
/// ends long before would be followed by any number of others.
void SteppedIntegrator::require_last_step() const {
  const bool same_nodes = left_.r.rows() == last_.r.rows() && right_.r.rows() == last_.r.rows();
  const double length = right_.time - left_.time;
  if (!same_nodes || !(next_ > 0) || !(length >= 0) ||
      !(right_.time >= last_.time - length - next_))
    throw InputError("the checkpoint's steps do not lead to its state");
}

}  // namespace deform
