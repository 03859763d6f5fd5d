#include "deform/solve/implicit_stage.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "deform/error.h"
#include "deform/geometry/rounding.h"

#include "not_finite.h"
#include "profile/profile.h"
#include "solve/implicit_equation.h"

namespace deform {
namespace {

/// A line search halves its step this often.
constexpr int kMostCuts = 30;
/// Armijo's condition: a step is taken where the potential falls by this part of what its slope
/// promised (Nocedal & Wright, chapter 3).
constexpr double kArmijo = 1e-4;
/// Such steps are taken before line searches, at most.
constexpr std::int64_t kMostLeaps = 30;
/// So many of them may go by before the potential is below its lowest value (a watchdog: Nocedal &
/// Wright, chapter 15.6).
constexpr int kMostPatience = 3;
/// Where they do not help, steps turn by this part of what they did; by so many times it where they
/// do.
constexpr double kShorter = 0.25, kLonger = 4;
/// Steps that turn no part of the surface by more than this go straight; none turns one by more
/// than that; where not even so small a turn helps, a line search does [rad].
constexpr double kStraight = 1e-3, kLargestTurn = 1, kSmallestTurn = 0.03;
/// How often a step that helped is doubled as long as it helps more.
constexpr int kMostDoublings = 6;
/// What a sum of energies may be wrong by, relative.
constexpr double kRoundingOfEnergy = 1e-13;
/// A Newton step below this part of the size and the rounding of positions moves nothing: what is
/// left over is the rounding of forces, of which some are far larger than all that is at work.
constexpr double kRoundingOfPositions = 1e-13;
/// Where no step moves anything, contact forces agree if making them the multipliers leaves no more
/// than so many times the residual.
constexpr double kSameResidual = 2;
/// Forces that cancel to this part of what they are made of count as balanced where no step helps.
constexpr double kRoundingOfForces = 1e-6;
/// Forces that no symmetric tangent knows (drag that turns, followers at a border): after so many
/// steps, and this close to a solution, their whole Jacobian is worth what it costs.
constexpr std::int64_t kSlow = 10;
constexpr double kClose = 0.2;
/// Forces of averaged strains are no gradient: Φ with the work of what is beside it may fall on and
/// on along a way that leads round. Where after so many steps nothing is close, a shorter time step
/// does better.
constexpr std::int64_t kMostRoundabout = 12;
/// Newton's method without a look at Φ goes on while a correction is this part of the one before,
/// at most, or what is left over of the forces, and this often.
constexpr double kContraction = 0.5;
constexpr int kMostContractions = 8;
/// Its first corrections are by projected tangents, later ones by exact ones.
constexpr int kProjected = 2;
/// Corrections so much smaller than the first need not shrink one by one.
constexpr double kSmall = 0.25;
/// A tangent serves twice where in the last stage the second correction was this part of the
/// first, at most, and if that is so again, or almost; and where no larger part of the forces at
/// work is left over at the guess. A kept tangent takes less of these away: more than that, and
/// they grow from step to step until a contraction fails.
constexpr double kGoodContraction = 0.15, kAlmostGood = 0.2, kCalmGuess = 0.3;
/// Part of a direction's error that an iterative solver may leave; and where it is a contraction's
/// second correction or a later one, which are smaller.
constexpr double kForcing = 0.02, kForcingOfLater = 0.1;
/// Part of the forces at work that may be left before a last correction: what it leaves of forces
/// makes no large displacements, but the next step's guess worse, and so on.
constexpr double kCalm = 0.1;

/// Part of the error that an iterative solver may leave of a contraction's correction number i.
double forcing(int i) { return i == 0 ? kForcing : kForcingOfLater; }

/// Has strains measured as a stage wants them while it lives, however the stage ends.
class StrainsOfAStage {
 public:
  StrainsOfAStage(System& system, const Stage& s) : system_(system) {
    if (s.by_strains) system_.measure_strains_from(1 / s.tau, s.start, s.s, s.earlier);
    if (s.averages_strains) system_.average_strains_from(s.start);
  }
  ~StrainsOfAStage() {
    system_.measure_strains_from(0, {});
    system_.end_average_of_strains();
  }
  StrainsOfAStage(const StrainsOfAStage&) = delete;
  StrainsOfAStage& operator=(const StrainsOfAStage&) = delete;

 private:
  System& system_;
};

/// θ, how large the second correction of a stage is, relative to its first, from earlier stages: as
/// measured, or after stages without a second one nearer and nearer to 1 (Hairer & Wanner, IV.8:
/// θ^0.8), so that sooner or later it is measured again.
class FirstContraction {
 public:
  /// Longer stages than that of the measurement contract worse: nothing is known.
  void begin_stage(double tau) {
    if (tau > tau_ * (1 + 1e-9)) theta_ = 1;
    tau_ = tau;
  }
  void measure(double theta) { theta_ = std::max(theta, kLeast); }
  /// A stage ends that did not measure it.
  void fade() { theta_ = std::pow(theta_, kFade); }
  [[nodiscard]] double theta() const { return theta_; }

  void save(Memory& memory) const { memory.put("contraction", {theta_, tau_}); }
  void load(const Memory& memory) {
    const std::vector<double>& known = memory.get("contraction", 2);
    theta_ = known[0], tau_ = known[1];
    if (theta_ < 0 || tau_ < 0) throw InputError("the checkpoint's \"contraction\" is none");
  }
  void forget() { theta_ = 1; }

 private:
  static constexpr double kFade = 0.8;
  /// Nothing is known so well as to hold for many stages.
  static constexpr double kLeast = 0.01;
  double theta_ = 1, tau_ = 0;  // tau: [s]
};

}  // namespace

struct ImplicitStage::Impl {
  explicit Impl(StageSettings s) : settings(s) {}

  void choose_guess(System& system, const Stage& stage, State& state);
  [[nodiscard]] bool contract(System& system, State& state);
  [[nodiscard]] bool find_correction(State& state, int i, bool keeps_tangent);
  [[nodiscard]] bool is_enough(double theta, double tolerance, double correction,
                               double norm) const;
  [[nodiscard]] std::string iterate(System& system, State& state);
  [[nodiscard]] double evaluate(System& system, State& state);
  [[nodiscard]] double evaluate_residual(System& system, State& state);
  void report(System& system, double norm) const;
  [[nodiscard]] bool contacts_agree(State& state, double norm);
  [[nodiscard]] bool is_converged(State& state, double norm);
  [[nodiscard]] std::string find_direction(State& state, std::int64_t iteration, double relative);
  [[nodiscard]] bool step(System& system, State& state);
  double go_farther(System& system, const NodeVectors& from, double s, double there, State& state);
  void remember(State& state, double merit);
  void go_back(State& state);
  [[nodiscard]] std::string search(System& system, State& state, double norm);
  [[nodiscard]] bool search_along(System& system, State& state, double norm);
  void go(System& system, const NodeVectors& from, double s, NodeVectors& r) const;
  /// Newton steps that are not longer move nothing [m].
  [[nodiscard]] double still(const State& state) const {
    return kRoundingOfPositions * equation.size() + rounding_of_positions(state.r);
  }

  StageSettings settings;
  ImplicitEquation equation;
  FirstContraction first_contraction;

  /// Where a way's merit is the lowest.
  struct Lowest {
    NodeVectors r;
    double merit = 0;
    ImplicitEquation::Way way;
  };
  Lowest lowest;
  double begun = 0;   // merit of the guess
  int patience = 0;   // steps since the lowest
  bool leaps = true;  // steps need not make the merit smaller one by one
  double turn = 0;    // the largest that a leap may make [rad]
  double tried = 0;   // that of the first since the lowest
  Tangent kind = Tangent::exact, next = Tangent::exact;
  NodeVectors guess;   // of a stage
  State begin;         // of a step, as a guess
  NodeVectors nearer;  // positions before a step is doubled
  NodeVectors before;  // positions before the last step
  NodeVectors direction;
  double angle = 0;    // by which it turns some part of the surface [rad]
  double longest = 0;  // of its nodes' ways [m]
};

/// Correction number i, by the tangent of the last one or by a new one; false where there is none.
bool ImplicitStage::Impl::find_correction(State& state, int i, bool keeps_tangent) {
  return (keeps_tangent ? equation.find_direction_again(forcing(i), direction)
                        : equation.find_direction(state, forcing(i), kind, direction))
      .empty();
}

/// Whether a correction, found to `tolerance`, that shrinks the error to `theta` of it leaves as
/// little as it may, of the error and of the residual before it; never where the residual alone
/// decides.
bool ImplicitStage::Impl::is_enough(double theta, double tolerance, double correction,
                                    double norm) const {
  const double left = std::max(theta, tolerance);
  return left * correction <= (1 - left) * settings.newton_error * equation.size() &&
         norm <= kCalm * equation.scale();
}

/// Newton's method by its corrections alone, from the guess; false where they do not shrink fast
/// enough, the state being the guess again. The first tangents are projected ones: far from the
/// solution the exact one is no better, costs more, and is often indefinite. The first serves the
/// second correction, too, where earlier ones shrank well; one that does not is none.
bool ImplicitStage::Impl::contract(System& system, State& state) {
  guess = state.r;
  double first = 0, last = 0, last_norm = kInfinity, theta = first_contraction.theta();
  equation.begin_way(state);
  system.step_report().residuals.clear();
  leaps = false;
  try {
    for (int i = 0; i < kMostContractions; ++i) {
      next = i < kProjected ? Tangent::projected : Tangent::exact;
      const Span span("Newton iteration");
      const bool keeps_tangent =
          i == 1 && theta <= kGoodContraction && last_norm <= kCalmGuess * equation.scale();
      const double norm =
          keeps_tangent ? evaluate_residual(system, state) : evaluate(system, state);
      if (norm <= settings.tolerance * equation.scale()) {
        if (i <= 1) first_contraction.fade();  // as little as that says nothing of larger ones
        return true;
      }
      ++system.step_report().iterations;
      if (!find_correction(state, i, keeps_tangent)) break;
      const double correction = system.root_mean_square(direction);
      if (i == 0) first = correction;
      if (i > 0) theta = correction / last;
      if (i == 1) first_contraction.measure(theta);
      if (keeps_tangent && !(theta <= kAlmostGood)) continue;
      const bool shrinks =
          theta <= kContraction || correction <= kSmall * first || norm <= kContraction * last_norm;
      if (i > 0 && !shrinks) break;
      state.r += direction;
      if (is_enough(theta, forcing(i), correction, norm)) {
        if (i == 0) first_contraction.fade();
        return true;
      }
      last = correction;
      last_norm = norm;
    }
  } catch (const NotFinite&) {
    // What went too far comes again from the guess.
  }
  first_contraction.forget();
  state.r = guess;
  return false;
}

/// The guess, or where the step began, whichever has the smaller merit.
void ImplicitStage::Impl::choose_guess(System& system, const Stage& stage, State& state) {
  const Span span("guess");
  begin = state;
  for (int c = 0; c < 3; ++c)
    for (Index a = 0; a < begin.r.rows(); ++a)
      if (system.reduction().free(a, c)) begin.r(a, c) = stage.start(a, c);
  system.follow_ties(begin.r);
  equation.begin_way(begin);
  const double at_begin = equation.merit(begin), guessed = equation.merit(state);
  if (!(guessed <= at_begin)) state = begin;
  system.step_report().potential_change = equation.has_potential() ? -at_begin : 0;
  equation.begin_way(state);
  begun = equation.merit(state);
}

/// Forces at the state; the residual.
double ImplicitStage::Impl::evaluate_residual(System& system, State& state) {
  const double norm = equation.evaluated_residual(state);
  report(system, norm);
  return norm;
}

void ImplicitStage::Impl::report(System& system, double norm) const {
  const double relative = !std::isfinite(norm)   ? kInfinity
                          : equation.scale() > 0 ? norm / equation.scale()
                                                 : 0;
  system.step_report().residual = relative;
  system.step_report().residuals.push_back(relative);
}

/// Forces and tangent at the state; the residual, infinite where there is none.
double ImplicitStage::Impl::evaluate(System& system, State& state) {
  kind = next;
  double norm = kInfinity;
  try {
    equation.evaluate(state, kind, before);
    norm = equation.residual(state);
  } catch (const NotFinite&) {
    if (!leaps || patience == 0) throw;
  }
  report(system, norm);
  return norm;
}

/// Whether contact forces are what they must be where those kept so far leave a residual of `norm`;
/// where they are not yet, makes them so, and the search begins again with their Φ.
bool ImplicitStage::Impl::contacts_agree(State& state, double norm) {
  if (!equation.has_contacts()) return true;
  const double updated = equation.update_contacts(state, kind);
  begun = equation.merit(state);
  remember(state, begun);
  longest = kInfinity;
  return !equation.has_new_planes() &&
         updated <= std::max(settings.tolerance * equation.scale(), kSameResidual * norm);
}

/// Whether what is left over is small enough, contact forces being what they must.
bool ImplicitStage::Impl::is_converged(State& state, double norm) {
  if (!(norm <= settings.tolerance * equation.scale())) return false;
  if (equation.has_contacts()) return contacts_agree(state, 0);
  if (!equation.has_potential() || !leaps) return true;
  return equation.merit(state) <= begun + kRoundingOfEnergy * std::abs(begun);
}

void ImplicitStage::Impl::remember(State& state, double merit) {
  lowest.r = state.r;
  lowest.merit = merit;
  lowest.way = equation.way();
  patience = 0;
}

void ImplicitStage::Impl::go_back(State& state) {
  state.r = lowest.r;
  equation.go_back_to(lowest.way);
  patience = 0;
  next = Tangent::exact;
}

/// Positions after s times the direction.
void ImplicitStage::Impl::go(System& system, const NodeVectors& from, double s,
                             NodeVectors& r) const {
  if (angle > kStraight)
    system.turn(s, r);
  else
    r = from + s * direction;
}

/// Doubles a step whose merit is `there` as long as that falls: the projected tangent is stiffer
/// than the surface, most so where it buckles. Returns the merit it comes to.
double ImplicitStage::Impl::go_farther(System& system, const NodeVectors& from, double s,
                                       double there, State& state) {
  for (int k = 0; kind == Tangent::projected && k < kMostDoublings; ++k) {
    nearer = state.r;
    go(system, from, 2 * s, state.r);
    const double farther = equation.merit(state);
    if (!(farther < there)) {
      state.r = nearer;
      break;
    }
    there = farther, s *= 2;
  }
  return there;
}

/// One step as it comes, but for the angle that it may turn by: Φ need not fall at once, as steps
/// into what a thin sheet resists most are taken back by the next. After a straight step the next
/// tangent is that of the stress which this one foresaw. Returns whether Φ is the lowest now; if
/// not, it may be back where it was.
bool ImplicitStage::Impl::step(System& system, State& state) {
  const Span span("step along the direction");
  before = state.r;
  if (patience == 0) tried = std::min(turn, angle);
  const double s = std::min(1.0, turn / std::max(angle, 1e-300));
  go(system, before, s, state.r);
  next = angle > kStraight ? Tangent::exact : Tangent::foreseen;
  const double merit = go_farther(system, before, s, equation.merit(state), state);
  if (merit < lowest.merit) {
    remember(state, merit);
    turn = std::min(kLargestTurn, kLonger * turn);
    return true;
  }
  if (++patience == kMostPatience) {
    go_back(state);
    turn = kShorter * tried;
    leaps = turn >= kSmallestTurn;
  }
  return false;
}

/// Goes along the direction as far as the merit falls; false where it does not.
bool ImplicitStage::Impl::search_along(System& system, State& state, double norm) {
  const Span span("line search");
  const double at_begin = equation.has_potential() ? equation.merit(state) : norm;
  const double slope = equation.has_potential() ? equation.slope(direction) : -norm;
  const double rounding = kRoundingOfEnergy * std::abs(at_begin);
  const NodeVectors from = state.r;
  double s = std::min(1.0, kLargestTurn / std::max(angle, 1e-300));
  for (int cut = 0; cut < kMostCuts; ++cut, s /= 2) {
    go(system, from, s, state.r);
    const double there = equation.merit(state);
    if (!(there <= at_begin + kArmijo * s * slope + rounding)) continue;
    if (cut == 0) (void)go_farther(system, from, s, there, state);
    return true;
  }
  state.r = from;
  return false;
}

/// A step by line search; "" or why there is none. Its tangent is the exact one, or if that does
/// not help the projected one.
std::string ImplicitStage::Impl::search(System& system, State& state, double norm) {
  const double relative = norm / equation.scale();
  next = Tangent::exact;
  if (search_along(system, state, norm)) return "";
  // Close to the end Φ changes by less than its rounding, and where a surface's frame is mixed a
  // force is not quite its gradient: the residual goes on.
  const NodeVectors from = state.r;
  state.r += direction;
  if (equation.evaluated_residual(state) < 0.5 * norm) return "";
  state.r = from;
  if (relative <= kRoundingOfForces) {
    longest = 0;
    return "";
  }
  if (kind == Tangent::projected || !equation.has_potential())
    return fmt::format("no step along Newton's direction helps (residual {:.3g})", relative);
  next = Tangent::projected;
  return "";
}

/// Newton's direction; "" or why there is none.
std::string ImplicitStage::Impl::find_direction(State& state, std::int64_t iteration,
                                                double relative) {
  if (!std::isfinite(relative)) return "forces are not finite";
  const bool is_slow = equation.has_potential() && !equation.is_gradient() &&
                       kind != Tangent::projected && iteration >= kSlow && relative <= kClose;
  if (is_slow && equation.find_full_direction(state, direction)) return "";
  return equation.find_direction(state, kForcing, kind, direction);
}

std::string ImplicitStage::Impl::iterate(System& system, State& state) {
  leaps = equation.has_potential();
  turn = kLargestTurn;
  next = Tangent::exact;
  longest = kInfinity;
  remember(state, begun);
  system.step_report().residuals.clear();
  double last = 0;  // correction; 0: none that the next can be compared with
  for (std::int64_t i = 0;; ++i) {
    const Span span("Newton iteration");
    if (leaps && i == kMostLeaps) {
      leaps = false;
      go_back(state);
    }
    const double norm = evaluate(system, state);
    if (is_converged(state, norm)) return "";
    if (longest <= still(state) && contacts_agree(state, norm)) return "";
    const double relative = system.step_report().residual;
    const bool goes_round = equation.averages_strains() && !equation.has_contacts() &&
                            i >= kMostRoundabout && relative > kClose;
    if (i == settings.iterations || goes_round || (!leaps && !std::isfinite(norm)))
      return relative <= settings.tolerance
                 ? fmt::format("contact forces do not settle in {} iterations", i)
                 : fmt::format("{} iterations leave a residual of {:.3g}", i, relative);
    ++system.step_report().iterations;
    std::string reason = find_direction(state, i, relative);
    if (!reason.empty()) {
      if (!leaps || patience == 0) return "no direction of descent (" + reason + ")";
      go_back(state);
      last = 0;
      turn *= kShorter;
      continue;
    }
    longest = direction.rowwise().norm().maxCoeff();
    if (longest <= still(state)) {
      if (contacts_agree(state, norm)) return "";
      continue;
    }
    angle = equation.has_potential() ? system.aim(state.r, direction) : 0;
    const double correction = system.root_mean_square(direction);
    const double theta = correction / std::exchange(last, correction);
    const bool may_end = leaps && angle <= turn && system.colliders() == 0 &&
                         is_enough(theta, kForcing, correction, norm);
    if (leaps) {
      const bool is_lowest = step(system, state);
      if (may_end && is_lowest) return "";
      if (patience == 0 && !is_lowest) last = 0;  // it went back
    } else if (reason = search(system, state, norm); !reason.empty()) {
      return reason;
    }
  }
}

ImplicitStage::ImplicitStage(StageSettings settings) : impl_(std::make_unique<Impl>(settings)) {}
ImplicitStage::~ImplicitStage() = default;

std::string ImplicitStage::solve(System& system, const Stage& stage, State& state) {
  const Span span("stage");
  Impl& s = *impl_;
  const StrainsOfAStage strains(system, stage);
  s.equation.begin(system, stage);
  s.first_contraction.begin_stage(stage.tau);
  StepReport& report = system.step_report();
  if (s.settings.newton_error > 0 && s.equation.has_potential() && system.colliders() == 0 &&
      s.contract(system, state)) {
    report.potential_change = std::nan("");  // Φ was not looked at
    s.equation.set_velocity(state);
    return "";
  }
  s.choose_guess(system, stage, state);
  std::string reason = s.iterate(system, state);
  if (!reason.empty()) return reason;
  if (s.equation.has_potential()) report.potential_change += s.equation.merit(state);
  // Without a potential of all forces Φ is another function along each way.
  if (s.equation.has_potential() && !s.equation.is_gradient())
    report.potential_change = std::nan("");
  s.equation.set_velocity(state);
  if (s.equation.has_contacts()) s.equation.contacts().forget_impacts(system, stage);
  return "";
}

std::vector<Index> ImplicitStage::touching() const { return impl_->equation.contacts().touching(); }
void ImplicitStage::settle(const System& system, const Stage& stage, double step,
                           State& end) const {
  if (impl_->equation.has_contacts())
    system.settle(step, impl_->equation.contacts().impulses(system, stage), end);
}
bool ImplicitStage::counts_corrections() const { return impl_->settings.newton_error > 0; }
bool ImplicitStage::resolves_contacts() const { return impl_->equation.has_potential(); }
void ImplicitStage::save(Memory& memory) const {
  impl_->equation.contacts().save(memory);
  if (counts_corrections()) impl_->first_contraction.save(memory);
}
void ImplicitStage::load(const Memory& memory) {
  impl_->equation.contacts().load(memory);
  if (counts_corrections()) impl_->first_contraction.load(memory);
}
void ImplicitStage::forget() {
  impl_->equation.contacts().forget();
  impl_->first_contraction.forget();
}

}  // namespace deform
