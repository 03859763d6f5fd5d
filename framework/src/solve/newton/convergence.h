/// When Newton's method has come close enough.
#pragma once

#include <algorithm>
#include <cmath>

#include "deform/plugin/values.h"
#include "deform/solve/newton.h"
#include "deform/solve/step_report.h"
#include "deform/types.h"

namespace deform {

/// Writes a residual, relative to the forces at work, to a report.
inline void note_residual(const Objective& f, double norm, StepReport& report) {
  report.residual = !std::isfinite(norm) ? kInfinity : f.scale() > 0 ? norm / f.scale() : 0;
  report.residuals.push_back(report.residual);
}

/// A correction, and what is known of it.
struct Correction {
  double theta = 0;      ///< it is this part of the one before
  double tolerance = 0;  ///< it was solved for to
  double length = 0;     ///< as Objective::length has it [m]
  double norm = 0;       ///< of the residual before it [N]
};

/// Part of the forces at work that may be left before a last correction: what it leaves of forces
/// makes no large displacements, but the next step's guess worse, and so on.
inline constexpr double kCalm = 0.1;

/// Whether a correction leaves as little as it may, of the error [m] and of the residual before it:
/// θ/(1 − θ) times its length (Hairer & Wanner, IV.8; Deuflhard). Never where the residual alone
/// decides.
[[nodiscard]] inline bool is_small_enough(const Correction& c, double error, double scale) {
  const double left = std::max(c.theta, c.tolerance);
  return left * c.length <= (1 - left) * error && c.norm <= kCalm * scale;
}

}  // namespace deform
