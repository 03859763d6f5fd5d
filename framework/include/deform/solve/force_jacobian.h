/// The derivative of all forces, by differences, and solutions with it.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "deform/export.h"
#include "deform/model/reduction.h"
#include "deform/solve/state.h"
#include "deform/solve/step_strains.h"
#include "deform/types.h"

namespace deform {

class System;

/// J = −∂f/∂r of all forces, by coloured central differences: for what has no tangent.
/// Unsymmetric; lagged coefficients move with the state. One for each use; `system` must live as
/// long.
class DEFORM_API ForceJacobian {
 public:
  /// `held`: free components that stay where they are (NewtonMatrix::hold_rigid_motions).
  explicit ForceJacobian(const System& system, const std::vector<Freedom>& held = {});
  ~ForceJacobian();
  ForceJacobian(const ForceJacobian&) = delete;
  ForceJacobian& operator=(const ForceJacobian&) = delete;

  /// Makes J that of a state. `rate`: dv/dr of an implicit step [1/s]: velocities move with
  /// positions. Throws NotFinite.
  void evaluate(const State& state, double rate = 0, const StepStrains* strains = nullptr);
  /// Factorises Tᵀ(J + diag(d))T, d (N) [N/m]; "" or why it cannot be factorised. Throws InputError
  /// where the scene names a solver that does not take such a matrix.
  [[nodiscard]] std::string factor(const NodeValues& d);
  /// As NewtonMatrix::solve.
  [[nodiscard]] std::string solve(const NodeVectors& b, NodeVectors& x);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace deform
