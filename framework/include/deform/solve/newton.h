/// Newton's method for what steps and equilibria of surfaces have in common.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "deform/export.h"
#include "deform/model/tangent.h"
#include "deform/solve/path.h"
#include "deform/solve/state.h"
#include "deform/solve/step_report.h"
#include "deform/types.h"

namespace deform {

class System;

/// What Newton's method solves: F(r) = 0 for a residual F (N × 3) [N], which is, where there is
/// one, the negative gradient of a potential Φ [J].
class DEFORM_API Objective {
 public:
  virtual ~Objective();

  /// Whether there is a Φ, which searches then lower; else they lower |F|, and directions are by
  /// differences.
  [[nodiscard]] virtual bool has_potential() const = 0;
  /// What searches lower at a state: Φ or |F|; infinite where it cannot be evaluated.
  [[nodiscard]] virtual double merit(State& state) = 0;
  /// Evaluates F and its tangent at a state; `before`: positions before the last straight step, for
  /// Tangent::mixed, or empty. Returns |F| [N].
  [[nodiscard]] virtual double evaluate(State& state, Tangent kind, const NodeVectors& before) = 0;
  /// Evaluates F alone.
  [[nodiscard]] virtual double evaluate_residual(State& state) = 0;
  /// Size of the forces at work in the last F, which the tolerance is relative to [N].
  [[nodiscard]] virtual double scale() const = 0;

  /// Newton's direction from the state of the last evaluation, by its tangent, or if that is not
  /// positive definite by one that is, so that the merit falls along it. `tolerance`: part of its
  /// error that an iterative solver may leave. `kind` becomes what it is of. Returns "" or why
  /// there is none.
  [[nodiscard]] virtual std::string find_direction(State& state, double tolerance, Tangent& kind,
                                                   NodeVectors& direction) = 0;
  /// From the last F, by the tangent of the last direction.
  [[nodiscard]] virtual std::string find_direction_again(double tolerance,
                                                         NodeVectors& direction) = 0;
  /// Φ's change by a unit step in a direction from the last evaluation, to first order [J].
  [[nodiscard]] virtual double slope(const NodeVectors& direction) const = 0;

  /// Puts positions that a path leads to where they may be (outside of bodies). A path's steps are
  /// judged by the merit there.
  virtual void confine(State& state);
  /// Whether the last `evaluate` made the merit another function (of friction where something
  /// touches for the first time).
  [[nodiscard]] virtual bool has_changed() const { return false; }

  /// How far along a path positions may go at once, 1 being Newton's step: what lies beyond is not
  /// admissible, or not to be trusted. More than 0; infinite where anything goes.
  [[nodiscard]] virtual double step_limit(const Path& path);
  /// Length of the surface [m], and of a displacement (N × 3) as errors are measured [m].
  [[nodiscard]] virtual double characteristic_length() const = 0;
  [[nodiscard]] virtual double length(const NodeVectors& displacement) const;
  /// A bound of the distance to the solution by what a direction promises of the merit, −slope [J],
  /// as `length` has it [m]; infinite where there is none.
  [[nodiscard]] virtual double distance_bound(double promised) const;
  /// Error that may be left at a state, beside NewtonSettings::error, as `length` has it [m].
  [[nodiscard]] virtual double error_allowed(const State& state) const;

  /// Why Newton's method takes a state for a solution.
  enum class Ending : std::uint8_t {
    residual,     ///< |F| is within the tolerance
    no_step,      ///< the last step has moved nothing
    no_distance,  ///< Newton's direction leads nowhere: F is rounding
    correction    ///< the last corrections leave less than the error allowed
  };
  /// Whether it is one; where not, F may have become another one (multipliers of contact, supports
  /// that were let go), and the search goes on with it from this state.
  [[nodiscard]] virtual bool accept(State& state, Tangent& kind, double norm, Ending ending);
  /// Whether `accept` never changes F.
  [[nodiscard]] virtual bool is_fixed() const { return true; }
  /// Whether the merit's second derivatives jump where Newton's steps go (friction's).
  [[nodiscard]] virtual bool has_kinks() const { return false; }
  /// Whether the merit can fall on and on along a path that leads round.
  [[nodiscard]] virtual bool may_go_round() const { return false; }
  /// Where the merit depends on the path that was taken (work of forces without a potential): keeps
  /// how it was taken to this state, to return to it.
  virtual void mark() {}
  virtual void return_to_mark() {}
};

struct NewtonSettings {
  double tolerance = 1e-6;       ///< of |F|, relative to Objective::scale
  std::int64_t iterations = 50;  ///< at most
  /// Steps that need not lower the merit one by one, at first, at most; then comes a line search.
  std::int64_t nonmonotone_steps = 30;
  /// Whether a watchdog looks at the merit during these; else whole steps are taken as they come,
  /// from the beginning again by line search where they do not converge.
  bool watches = true;
  /// Whether paths may rotate parts of the surface by finite angles.
  bool rotates = true;
  /// Error that may be left, as Objective::length has it, estimated from the last corrections [m];
  /// 0: the tolerance alone decides.
  double error = 0;
};

/// Newton's method with non-monotone steps at first (a watchdog: Nocedal & Wright, Numerical
/// Optimization, chapter 15.6), then with a line search (chapter 3).
class DEFORM_API Newton {
 public:
  /// `system` must live as long.
  explicit Newton(const System& system);
  ~Newton();
  Newton(const Newton&) = delete;
  Newton& operator=(const Newton&) = delete;

  /// From a guess to a solution; `merit`: that of the guess, or not a number where nobody has asked
  /// for it yet. Returns "" or why there is none; `state` is then of no use. Adds to the report.
  [[nodiscard]] std::string solve(Objective& objective, const NewtonSettings& settings,
                                  double merit, State& state, StepReport& report);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace deform
