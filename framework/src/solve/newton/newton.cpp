#include "deform/solve/newton.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "deform/error.h"
#include "deform/geometry/rounding.h"
#include "deform/plugin/values.h"

#include "not_finite.h"
#include "profile/profile.h"
#include "solve/newton/constants.h"
#include "solve/newton/convergence.h"

namespace deform {
namespace {

/// A line search halves its step this often.
constexpr int kMostCuts = 30;
/// Armijo's condition: a step is taken where the merit falls by this part of what its slope
/// promised (Nocedal & Wright, chapter 3).
constexpr double kArmijo = 1e-4;
/// So many non-monotone steps may go by before the merit is below its lowest value (a watchdog:
/// Nocedal & Wright, chapter 15.6).
constexpr int kMostPatience = 3;
/// Where they do not help, paths rotate by this part of what they did; by so many times it where
/// they do.
constexpr double kShorter = 0.25, kLonger = 4;
/// No path rotates a part of the surface by more than the first; where not even a rotation as small
/// as the second helps, a line search does [rad].
constexpr double kLargestRotation = 1, kSmallestRotation = 0.03;
/// Of a merit with kinks a step that does not help is halved so often at once, as Newton's steps go
/// to and fro between both sides of one.
constexpr int kMostKinks = 3;
/// Beside what kinks make of them, directions need not be as good.
constexpr double kForcingAtKinks = 0.1;
/// How often a step that helped is doubled as long as it helps more.
constexpr int kMostDoublings = 6;
/// What a sum of energies may be wrong by, relative.
constexpr double kRoundingOfEnergy = 1e-13;
/// Where a merit may fall on and on along a path that leads round, and after so many steps nothing
/// is close, a shorter time step does better.
constexpr std::int64_t kMostRoundabout = 12;

}  // namespace

Objective::~Objective() = default;
void Objective::confine(State& /*state*/) {}
double Objective::step_limit(const Path& /*path*/) { return kInfinity; }
double Objective::length(const NodeVectors& displacement) const {
  return displacement.rowwise().norm().maxCoeff();
}
double Objective::distance_bound(double /*promised*/) const { return kInfinity; }
double Objective::error_allowed(const State& /*state*/) const { return 0; }
bool Objective::accept(State& /*state*/, Tangent& /*kind*/, double /*norm*/, Ending /*ending*/) {
  return true;
}

struct Newton::Impl {
  explicit Impl(const System& system) : path(system) {}

  [[nodiscard]] std::string iterate(State& state);
  void begin(State& state, double merit);
  [[nodiscard]] double evaluate(State& state);
  [[nodiscard]] bool is_converged(State& state, double norm);
  [[nodiscard]] bool accepts(State& state, double norm, Objective::Ending ending);
  [[nodiscard]] bool leaves_little(const State& state, const Correction& correction) const;
  [[nodiscard]] bool ends(State& state);
  [[nodiscard]] std::string find_direction(State& state, double relative);
  [[nodiscard]] std::string why_no_solution(std::int64_t iteration, double relative) const;
  /// Part of a direction's error that may be left.
  [[nodiscard]] double forcing() const { return f->has_kinks() ? kForcingAtKinks : kForcing; }
  [[nodiscard]] bool may_go_back() const { return is_nonmonotone && patience > 0; }
  [[nodiscard]] bool take_whole_step(State& state, double limit);
  [[nodiscard]] bool take_watched_step(State& state, double limit);
  [[nodiscard]] std::string search(State& state, double norm, double limit);
  [[nodiscard]] bool search_along(State& state, double norm, double limit);
  double go_farther(double here, double s, double there, double limit, State& state);
  void move(double s, State& state) const;
  void begin_anew(State& state);
  void remember(State& state, double merit);
  void go_back(State& state);
  void end_nonmonotone(State& state);
  /// Newton steps that are not longer move nothing [m].
  [[nodiscard]] double still(const State& state) const {
    return kRoundingOfPositions * f->characteristic_length() + rounding_of_positions(state.r);
  }

  Path path;
  // Of one solution:
  Objective* f = nullptr;
  NewtonSettings settings;
  StepReport* report = nullptr;
  /// Where the merit is the lowest.
  struct Lowest {
    NodeVectors r;
    double merit = 0;
  };
  Lowest lowest;
  double begun = 0;            // merit of the guess
  int patience = 0;            // steps since the lowest
  bool is_nonmonotone = true;  // steps need not lower the merit one by one
  double rotation = 0;         // the largest that a non-monotone step may make [rad]
  double tried = 0;            // that of the first since the lowest
  Tangent kind = Tangent::exact, next = Tangent::exact;
  NodeVectors before;  // positions before the last step
  NodeVectors nearer;  // positions before a step is doubled
  NodeVectors direction;
  double moved = kInfinity;    // the farthest node, in the last step [m]
  double searched = 0;         // how far along the last path a line search went
  double last_correction = 0;  // 0: none that the next can be compared with
};

Newton::Newton(const System& system) : impl_(std::make_unique<Impl>(system)) {}
Newton::~Newton() = default;

std::string Newton::solve(Objective& objective, const NewtonSettings& settings, double merit,
                          State& state, StepReport& report) {
  impl_->f = &objective;
  impl_->settings = settings;
  impl_->report = &report;
  impl_->begin(state, merit);
  return impl_->iterate(state);
}

void Newton::Impl::begin(State& state, double merit) {
  is_nonmonotone = settings.nonmonotone_steps > 0 && (f->has_potential() || !settings.watches);
  rotation = kLargestRotation;
  kind = next = Tangent::exact;
  moved = kInfinity;
  last_correction = 0;
  before.resize(0, 3);
  begun = merit;
  remember(state, begun);
  report->residuals.clear();
}

/// Forces and tangent at the state; the residual, infinite where there is none.
double Newton::Impl::evaluate(State& state) {
  kind = next;
  double norm = kInfinity;
  try {
    norm = f->evaluate(state, kind, before);
  } catch (const NotFinite&) {
    if (!may_go_back()) throw;
  }
  note_residual(*f, norm, *report);
  return norm;
}

/// Whether the state is a solution; where it is none yet, the search begins again.
bool Newton::Impl::accepts(State& state, double norm, Objective::Ending ending) {
  if (f->accept(state, kind, norm, ending)) return true;
  ++report->contact_changes;
  begin_anew(state);
  before.resize(0, 3);
  return false;
}

/// Whether a correction leaves no more than the error allowed: by how corrections shrink, or, where
/// kinks make them jump, by what it promises of the merit (Newton's decrement: Boyd &
/// Vandenberghe, chapter 9.5). The projected tangent, stiffer than the surface, promises too little
/// where forces are not nearly balanced.
bool Newton::Impl::leaves_little(const State& state, const Correction& correction) const {
  const double error = std::max(settings.error, f->error_allowed(state));
  if (is_small_enough(correction, error, f->scale())) return true;
  const bool is_calm = kind != Tangent::projected || correction.norm <= kCalm * f->scale();
  return f->has_kinks() && is_calm && f->distance_bound(-f->slope(direction)) <= error;
}

/// Whether the state that the last correction led to is a solution.
bool Newton::Impl::ends(State& state) {
  if (f->is_fixed()) return true;
  const double norm = f->evaluate_residual(state);
  return norm <= kCalm * f->scale() && accepts(state, norm, Objective::Ending::correction);
}

/// With another merit, from here.
void Newton::Impl::begin_anew(State& state) {
  if (f->has_potential() && settings.watches) begun = f->merit(state);
  remember(state, begun);
  moved = kInfinity;
}

/// Positions at s of the path, or the nearest where they may be.
void Newton::Impl::move(double s, State& state) const {
  path.at(s, state.r);
  f->confine(state);
}

/// Whether the residual is small enough; after non-monotone steps the merit must not be larger than
/// that of the guess.
bool Newton::Impl::is_converged(State& state, double norm) {
  if (!(norm <= settings.tolerance * f->scale())) return false;
  const bool is_watched = is_nonmonotone && settings.watches && f->has_potential();
  if (is_watched && f->is_fixed() &&
      !(f->merit(state) <= begun + kRoundingOfEnergy * std::abs(begun)))
    return false;
  return accepts(state, norm, Objective::Ending::residual);
}

void Newton::Impl::remember(State& state, double merit) {
  lowest.r = state.r;
  lowest.merit = merit;
  f->mark();
  patience = 0;
}

void Newton::Impl::go_back(State& state) {
  state.r = lowest.r;
  f->return_to_mark();
  patience = 0;
  next = Tangent::exact;
}

/// From the lowest merit, or where nobody looked at it from the beginning.
void Newton::Impl::end_nonmonotone(State& state) {
  is_nonmonotone = false;
  go_back(state);
  before.resize(0, 3);
  moved = kInfinity;
}

/// Doubles a step from where the merit was `here` to where it is `there` as long as that falls: the
/// projected tangent is stiffer than the surface, most so where it buckles. Is not tried where the
/// parabola through both merits with the slope at first would rise: there it fell by less than two
/// thirds of what the slope alone says. Returns the merit it comes to.
double Newton::Impl::go_farther(double here, double s, double there, double limit, State& state) {
  const double slope = f->has_potential() ? f->slope(direction) : 0;
  for (int k = 0; kind == Tangent::projected && k < kMostDoublings && 2 * s <= limit; ++k) {
    if (3 * (here - there) < -2 * s * slope) break;
    nearer = state.r;
    move(2 * s, state);
    const double farther = f->merit(state);
    if (!(farther < there)) {
      state.r = nearer;
      break;
    }
    there = farther, s *= 2;
  }
  return there;
}

/// One step as it comes, but for the angle that it may rotate by: the merit need not fall at once,
/// as steps into what a thin sheet resists most are taken back by the next. After a straight step
/// the next tangent is that of the stress which this one predicted. Returns whether the merit is
/// the lowest now; if not, it may be back where it was.
bool Newton::Impl::take_watched_step(State& state, double limit) {
  const Span span("step along the direction");
  before = state.r;
  if (patience == 0) tried = std::min(rotation, path.angle());
  double s = std::min({1.0, limit, rotation / std::max(path.angle(), 1e-300)});
  move(s, state);
  next = path.is_straight() ? Tangent::mixed : Tangent::exact;
  const double here = patience == 0 ? lowest.merit : kInfinity;
  double merit = go_farther(here, s, f->merit(state), limit, state);
  for (int cut = 0; f->has_kinks() && !(merit < lowest.merit) && cut < kMostKinks; ++cut) {
    s /= 2;
    move(s, state);
    merit = f->merit(state);
  }
  if (merit < lowest.merit) {
    remember(state, merit);
    rotation = std::min(kLargestRotation, kLonger * rotation);
    return true;
  }
  if (++patience == kMostPatience) {
    go_back(state);
    rotation = kShorter * tried;
    is_nonmonotone = rotation >= kSmallestRotation;
  }
  return false;
}

/// One step as it comes; false where it may not be taken, or its tangent is not the exact one.
bool Newton::Impl::take_whole_step(State& state, double limit) {
  if (kind == Tangent::projected || !(limit >= 1)) return false;
  before = state.r;
  move(1, state);
  next = Tangent::mixed;
  ++patience;
  return true;
}

/// Goes along the path as far as the merit falls; false where it does not.
bool Newton::Impl::search_along(State& state, double norm, double limit) {
  const Span span("line search");
  const double at_begin = f->has_potential() ? f->merit(state) : norm;
  const double slope = f->has_potential() ? f->slope(direction) : -norm;
  const double rounding = kRoundingOfEnergy * std::abs(at_begin);
  const NodeVectors from = state.r;
  searched = 0;
  double s = std::min({1.0, limit, kLargestRotation / std::max(path.angle(), 1e-300)});
  for (int cut = 0; cut < kMostCuts; ++cut, s /= 2) {
    move(s, state);
    const double there = f->merit(state);
    if (!(there <= at_begin + kArmijo * s * slope + rounding)) continue;
    searched = s;
    if (cut == 0) (void)go_farther(at_begin, s, there, limit, state);
    return true;
  }
  state.r = from;
  return false;
}

/// A step by line search; "" or why there is none. Its tangent is the exact one, or if that does
/// not help the projected one.
std::string Newton::Impl::search(State& state, double norm, double limit) {
  const double relative = norm / f->scale();
  next = Tangent::exact;
  if (search_along(state, norm, limit)) return "";
  // Close to the end Φ changes by less than its rounding, and where a surface's frame is mixed a
  // force is not quite its gradient: the residual goes on.
  const NodeVectors from = state.r;
  move(std::min(1.0, limit), state);
  if (f->evaluate_residual(state) < 0.5 * norm) return "";
  state.r = from;
  if (relative <= kRoundingOfForces) {
    moved = 0;
    return "";
  }
  if (kind == Tangent::projected || !f->has_potential())
    return fmt::format("no step along Newton's direction helps (residual {:.3g})", relative);
  next = Tangent::projected;
  return "";
}

/// Newton's direction; "" or why there is none.
std::string Newton::Impl::find_direction(State& state, double relative) {
  if (!std::isfinite(relative)) return "forces are not finite";
  std::string reason = f->find_direction(state, forcing(), kind, direction);
  if (kind == Tangent::projected) ++report->projected;
  return reason;
}

std::string Newton::Impl::why_no_solution(std::int64_t iteration, double relative) const {
  return relative <= settings.tolerance
             ? fmt::format("contact forces do not settle in {} iterations", iteration)
             : fmt::format("{} iterations leave a residual of {:.3g}", iteration, relative);
}

std::string Newton::Impl::iterate(State& state) {
  for (std::int64_t i = 0;; ++i) {
    const Span span("Newton iteration");
    if (is_nonmonotone && i == settings.nonmonotone_steps) end_nonmonotone(state);
    const double norm = evaluate(state);
    if (f->has_changed()) {
      ++report->contact_changes;
      begin_anew(state);
    }
    if (is_converged(state, norm)) return "";
    if (moved <= still(state) && accepts(state, norm, Objective::Ending::no_step)) return "";
    const double relative = report->residual;
    const bool goes_round = f->may_go_round() && i >= kMostRoundabout && relative > kClose;
    if (i == settings.iterations || goes_round || (!is_nonmonotone && !std::isfinite(norm)))
      return why_no_solution(i, relative);
    ++report->iterations;
    std::string reason = find_direction(state, relative);
    if (!reason.empty()) {
      if (!may_go_back()) return "no direction of descent (" + reason + ")";
      go_back(state);
      last_correction = 0;
      rotation *= kShorter;
      if (!settings.watches) end_nonmonotone(state);
      continue;
    }
    const bool stays_projected = f->has_kinks() && kind == Tangent::projected && relative > kClose;
    path.begin(state.r, direction, settings.rotates && f->has_potential());
    moved = path.length();
    if (moved <= still(state)) {
      if (accepts(state, norm, Objective::Ending::no_distance)) return "";
      continue;
    }
    const double limit = f->step_limit(path);
    if (is_nonmonotone && !settings.watches) {
      if (!take_whole_step(state, limit)) end_nonmonotone(state);
      continue;
    }
    const double correction = f->length(direction);
    const double theta = correction / std::exchange(last_correction, correction);
    const bool may_end = path.angle() <= (is_nonmonotone ? rotation : kLargestRotation) &&
                         limit >= 1 && leaves_little(state, {theta, forcing(), correction, norm});
    if (is_nonmonotone) {
      const bool is_lowest = take_watched_step(state, limit);
      if (stays_projected) next = Tangent::projected;
      if (may_end && is_lowest && ends(state)) return "";
      if (patience == 0 && !is_lowest) last_correction = 0;  // it went back
    } else {
      reason = search(state, norm, limit);
      if (!reason.empty()) return reason;
      if (stays_projected) next = Tangent::projected;
      if (may_end && searched >= 1 && f->has_kinks() && ends(state)) return "";
      if (searched < 1) last_correction = 0;
    }
  }
}

}  // namespace deform
