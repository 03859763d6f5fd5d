/// The lagged operator of semi-implicit steps, and solutions with it.
#pragma once

#include <memory>

#include "deform/export.h"
#include "deform/solve/sparse_matrix.h"
#include "deform/solve/state.h"
#include "deform/types.h"

namespace deform {

class System;

/// K (N × N, shared by x, y, z) with f(r) = c − K r at the state that it was evaluated at, and its
/// linear solver. One for each use; `system` must live as long.
class DEFORM_API LaggedMatrix {
 public:
  explicit LaggedMatrix(const System& system);
  ~LaggedMatrix();
  LaggedMatrix(const LaggedMatrix&) = delete;
  LaggedMatrix& operator=(const LaggedMatrix&) = delete;

  /// Evaluates all forces at a state, to f (N × 3) [N], and K.
  void evaluate(const State& state, NodeVectors& f);
  /// Of the last evaluation: (N) −∂f/∂v, or what bounds it, of force fields that say so [N·s/m].
  [[nodiscard]] const NodeValues& force_damping() const;
  [[nodiscard]] const SparseMatrix& matrix() const;

  /// Chooses the linear solver now, else the first `solve` does. Throws InputError when none takes
  /// this model's matrices.
  void choose_solver();
  /// Solves (K + diag(d)) x = b on the free degrees of freedom; prescribed entries of x (N × 3) are
  /// given, the others a guess, for iterative solvers, which solve to `tolerance`
  /// (LinearSolver::improve). Throws Error with ExitCode::diverged and each solver's reason when
  /// none can.
  void solve(const NodeValues& d, const NodeVectors& b, NodeVectors& x, double tolerance);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace deform
