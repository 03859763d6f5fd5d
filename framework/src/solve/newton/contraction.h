/// Newton's method by its corrections alone, where they shrink fast.
#pragma once

#include "deform/plugin/plugin.h"
#include "deform/solve/newton.h"

namespace deform {

/// Whole straight steps, as long as the objective admits them, without a look at the merit: lengths
/// ‖Δ_k‖, or the residual, must shrink by a factor of two at least, or the lengths to a quarter of
/// the first's, until θ/(1 − θ) ‖Δ_k‖, θ = ‖Δ_k‖/‖Δ_k−1‖ (at the first that of earlier solutions;
/// at least what an iterative solver may leave), is below the error, and forces are nearly balanced
/// (Hairer & Wanner, IV.8; Deuflhard's natural monotonicity test).
class Contraction {
 public:
  /// Solutions of a stage of length τ [s] follow: those of longer ones than before contract worse.
  void begin_stage(double tau);
  /// From a guess; false where corrections do not shrink fast enough, the state being the guess
  /// again.
  [[nodiscard]] bool solve(Objective& objective, const NewtonSettings& settings, Path& path,
                           State& state, StepReport& report);

  void save(Memory& memory) const;
  void load(const Memory& memory);
  /// As if there had been no solution yet.
  void forget() { theta_ = 1; }

 private:
  [[nodiscard]] bool contract(Objective& f, const NewtonSettings& settings, Path& path,
                              State& state, StepReport& report);
  void measure(double theta);
  void fade();

  double theta_ = 1;  // of a solution's second correction: as known from earlier ones
  double tau_ = 0;    // [s]
  NodeVectors guess_, direction_;
};

}  // namespace deform
