/// The tangent of a model, and solutions with it.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "deform/export.h"
#include "deform/model/reduction.h"
#include "deform/model/tangent.h"
#include "deform/solve/block_matrix.h"
#include "deform/solve/state.h"
#include "deform/solve/step_strains.h"
#include "deform/types.h"

namespace deform {

class System;

/// Which tangent.
struct TangentRequest {
  Tangent kind = Tangent::exact;
  /// Positions (N × 3) before the last Newton step, for Tangent::mixed.
  const NodeVectors* before = nullptr;
  /// dv/dr of an implicit step [1/s], for what depends on velocities: where v = (r − b)·rate, its
  /// −∂f/∂v (or what bounds it) times `rate` is added.
  double rate = 0;
  /// Null: strains of the state. It must live until the next evaluation.
  const StepStrains* strains = nullptr;
  /// For `solve_to` above all: rows go to a solver that takes them as they are made, and the matrix
  /// is kept nowhere else; whatever else wants it has it made again. It changes no result.
  bool for_directions = false;
};

/// A 3 × 3 block [N/m] of a symmetric matrix at (a, b), its transpose being at (b, a).
struct BlockEntry {
  Index a = 0, b = 0;
  Eigen::Matrix3d block = Eigen::Matrix3d::Zero();
};

/// K = −∂f/∂r of all terms with a potential and all force fields that know theirs, an approximation
/// of it of other terms (JetTerm::tangent), what else is added to it, and its linear solvers. One
/// for each use; `system` must live as long.
class DEFORM_API NewtonMatrix {
 public:
  explicit NewtonMatrix(const System& system);
  ~NewtonMatrix();
  NewtonMatrix(const NewtonMatrix&) = delete;
  NewtonMatrix& operator=(const NewtonMatrix&) = delete;

  /// Makes K the tangent at a state. Throws NotFinite.
  void evaluate(const State& state, const TangentRequest& request = {});
  /// Adds to K, until the next evaluation: forces that the model's parts do not know (contact).
  /// Between any two nodes; where the pattern has no such block, it grows.
  void add(std::span<const BlockEntry> entries);
  [[nodiscard]] const BlockMatrix& matrix();
  /// (N) A third of the trace of each node's diagonal block [N/m].
  [[nodiscard]] NodeValues mean_stiffness();

  /// Factorises Tᵀ(K + diag(d))T, d (N) for x, y and z alike [N/m]. Returns "" or why it is not
  /// positive definite.
  [[nodiscard]] std::string factor(const NodeValues& d);
  /// Solves with that factor: x = T y, Tᵀ(K + diag(d))T y = Tᵀb; b and x (N × 3). Prescribed
  /// components of x are 0. Returns "" or why the solver cannot.
  [[nodiscard]] std::string solve(const NodeVectors& b, NodeVectors& x);
  /// Both at once, for directions that need not be exact: the solution's error, in a norm of the
  /// solver's choice, is `tolerance` of that of 0 or less. Iterative where a solver suits, which
  /// hands on to a factorisation where it cannot. Returns "" or why the matrix is not positive
  /// definite.
  [[nodiscard]] std::string solve_to(double tolerance, const NodeValues& d, const NodeVectors& b,
                                     NodeVectors& x);
  /// Once more, with the matrix of the last `solve_to`.
  [[nodiscard]] std::string solve_again(double tolerance, const NodeVectors& b, NodeVectors& x);
  /// That the last `solve_to` or `solve_again` took; 0 where it was exact.
  [[nodiscard]] long solver_iterations() const;

  /// Holds as many components as it takes for a surface at a state that neither its constraints nor
  /// force fields with a stiffness, at the state's time, hold in space (statics, where inertia does
  /// not either), in `factor` and `solve` from now on. Returns them. K becomes that of the state.
  std::vector<Freedom> hold_rigid_motions(const State& state);

  /// The lowest eigenvalue of K x = λ M x on what is free [1/s²]; how many are negative; and its x
  /// (N × 3).
  struct Stability {
    double lowest = 0;
    Index negative = 0;
    NodeVectors mode;
  };
  [[nodiscard]] Stability stability();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace deform
