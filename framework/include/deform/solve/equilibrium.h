/// Equilibria under parts of a step's load.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "deform/export.h"
#include "deform/model/reduction.h"
#include "deform/solve/newton_matrix.h"
#include "deform/solve/system.h"

namespace deform {

struct EquilibriumSettings {
  double tolerance = 1e-9;       ///< of the residual, relative to the forces at work
  std::int64_t iterations = 50;  ///< of Newton's method with a line search, at most
};

/// f(r) = (1 − λ) f0 for r, f0 being the force at the step's beginning under the loads of its end,
/// prescribed components moving along with λ from 0 to 1. Where all has a potential Π, solutions
/// are stationary points of Π + (1 − λ) f0·r.
class DEFORM_API Equilibrium {
 public:
  explicit Equilibrium(EquilibriumSettings settings);
  ~Equilibrium();
  Equilibrium(const Equilibrium&) = delete;
  Equilibrium& operator=(const Equilibrium&) = delete;

  /// Begins a step from a state to a time [s].
  void begin(System& system, const State& from, double end);
  /// Whether all has a potential and a tangent; else directions are by differences of the force.
  [[nodiscard]] bool has_potential() const;
  /// Makes `state`, a guess, the equilibrium under a part λ of the load; "" or why there is none.
  /// Throws Error (diverged) where loads that nothing holds do not balance.
  [[nodiscard]] std::string solve(double lambda, State& state);
  /// The same to first order, with the tangent at `state`, where the step begins, λ = 1.
  [[nodiscard]] std::string solve_linear(State& state);
  /// The exact tangent, with what it takes to hold the surface.
  [[nodiscard]] NewtonMatrix& matrix();

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace deform
