#include "solve/newton/contraction.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "deform/error.h"

#include "not_finite.h"
#include "profile/profile.h"
#include "solve/newton/constants.h"
#include "solve/newton/convergence.h"

namespace deform {
namespace {

/// It goes on while a correction is this part of the one before, at most, or the residual is, and
/// this often.
constexpr double kContraction = 0.5;
constexpr int kMostContractions = 8;
/// Its first corrections are by projected tangents, later ones by exact ones.
constexpr int kProjected = 2;
/// Corrections so much smaller than the first need not shrink one by one.
constexpr double kSmall = 0.25;
/// A tangent serves twice where in the last stage the second correction was this part of the first,
/// at most, and if that is so again, or almost; and where no larger part of the forces at work is
/// left of the residual at the guess. A kept tangent takes less of these away: more than that, and
/// they grow from step to step until a contraction fails.
constexpr double kGoodContraction = 0.15, kAlmostGood = 0.2, kCalmGuess = 0.3;
/// Part of a direction's error that an iterative solver may leave of the second correction or a
/// later one, which are smaller.
constexpr double kForcingOfLater = 0.1;
/// What was measured fades from stage to stage, so that sooner or later it is measured again
/// (Hairer & Wanner, IV.8: θ^0.8); and nothing is known so well as to hold for many stages.
constexpr double kFade = 0.8, kLeast = 0.01;

double forcing(int i) { return i == 0 ? kForcing : kForcingOfLater; }

}  // namespace

void Contraction::begin_stage(double tau) {
  if (tau > tau_ * (1 + 1e-9)) theta_ = 1;
  tau_ = tau;
}
void Contraction::measure(double theta) { theta_ = std::max(theta, kLeast); }
/// A solution ends that did not measure it.
void Contraction::fade() { theta_ = std::pow(theta_, kFade); }

void Contraction::save(Memory& memory) const { memory.put("contraction", {theta_, tau_}); }

void Contraction::load(const Memory& memory) {
  const std::vector<double>& known = memory.get("contraction", 2);
  theta_ = known[0], tau_ = known[1];
  if (theta_ < 0 || tau_ < 0) throw InputError("the checkpoint's \"contraction\" is none");
}

bool Contraction::solve(Objective& objective, const NewtonSettings& settings, Path& path,
                        State& state, StepReport& report) {
  guess_ = state.r;
  report.residuals.clear();
  try {
    if (contract(objective, settings, path, state, report)) return true;
  } catch (const NotFinite&) {
    // What went too far comes again from the guess.
  }
  forget();
  state.r = guess_;
  return false;
}

/// The first tangents are projected ones: far from the solution the exact one is no better, costs
/// more, and is often indefinite. The first serves the second correction, too, where earlier ones
/// shrank well; one that does not is none.
bool Contraction::contract(Objective& f, const NewtonSettings& settings, Path& path, State& state,
                           StepReport& report) {
  double first = 0, last = 0, last_norm = kInfinity, theta = theta_;
  for (int i = 0; i < kMostContractions; ++i) {
    const Span span("Newton iteration");
    Tangent kind = i < kProjected ? Tangent::projected : Tangent::exact;
    const bool keeps_tangent =
        i == 1 && theta <= kGoodContraction && last_norm <= kCalmGuess * f.scale();
    const double norm = keeps_tangent ? f.evaluate_residual(state) : f.evaluate(state, kind, {});
    note_residual(f, norm, report);
    if (norm <= settings.tolerance * f.scale()) {
      if (i <= 1) fade();  // as little as that says nothing of larger ones
      return true;
    }
    ++report.iterations;
    const std::string reason = keeps_tangent
                                   ? f.find_direction_again(forcing(i), direction_)
                                   : f.find_direction(state, forcing(i), kind, direction_);
    if (!reason.empty()) return false;
    const double correction = f.length(direction_);
    if (i == 0) first = correction;
    if (i > 0) theta = correction / last;
    if (i == 1) measure(theta);
    if (keeps_tangent && !(theta <= kAlmostGood)) continue;
    const bool shrinks =
        theta <= kContraction || correction <= kSmall * first || norm <= kContraction * last_norm;
    if (i > 0 && !shrinks) return false;
    path.begin(state.r, direction_, false);
    if (!(f.step_limit(path) >= 1)) return false;
    path.at(1, state.r);
    f.confine(state);
    const double error = std::max(settings.error, f.error_allowed(state));
    if (is_small_enough({theta, forcing(i), correction, norm}, error, f.scale())) {
      if (i == 0) fade();
      return true;
    }
    last = correction;
    last_norm = norm;
  }
  return false;
}

}  // namespace deform
