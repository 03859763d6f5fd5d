/// Solves (K + diag(d)) x = b with a tangent K of 3 × 3 blocks, on the free degrees of freedom.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "deform/solve/block_matrix.h"
#include "deform/solve/model_parts.h"

#include "solve/matrix/reduced_matrix.h"
#include "solve/matrix/solver_queue.h"
#include "solve/matrix/unknowns.h"

namespace deform {

/// Exactly, by a factorisation; or to a tolerance, by a solver that takes the blocks as they are
/// where one suits the size and nothing is tied.
class TangentSolver {
 public:
  /// Gives K where a factorisation needs it.
  using Whole = std::function<const BlockMatrix&()>;
  /// What a factorisation has room for: all entries of the pattern's blocks; or, where K never
  /// changes, those that are not 0, which for multiples of the identity is a third, and far less of
  /// what they fill in.
  enum class Entries : std::uint8_t { all, nonzero };
  /// `held`: unknowns that stay where they are, so that the surface does not move as a rigid body.
  TangentSolver(const ReductionMap& map, const BlockMatrix& pattern,
                const std::vector<Freedom>& held, const SolverSource& solvers, Whole whole,
                Entries entries = Entries::all);

  [[nodiscard]] const Unknowns& unknowns() const { return unknowns_; }

  /// d: (N) for all three components. Returns "" or why the matrix is not positive definite.
  [[nodiscard]] std::string factor(const NodeValues& d);
  /// x = T y with Tᵀ(K + diag(d))T y = Tᵀb, of the last factor that could; b (N × 3), x (N × 3).
  [[nodiscard]] std::string solve(const NodeVectors& b, NodeVectors& x);

  /// Whether solutions to a tolerance are by a solver that wants the rows of K, by `put`, before
  /// `factor_to_tolerance`.
  [[nodiscard]] bool takes_rows();
  /// Thread-safe for different rows.
  void put(const BlockRows& rows);
  /// All rows.
  void put(const BlockMatrix& k);
  /// The same as `factor` and `solve` for solutions whose error is reduced to a tolerance.
  /// `beside_rows`: d and what the rows that were put lack of K's diagonal (N); `blocks`: what they
  /// lack of its diagonal blocks beside. `renew`: nothing
  /// that was prepared for earlier matrices may be used. Both return "" or why the matrix is not
  /// positive definite, which an iterative solver may find only in the end.
  [[nodiscard]] std::string factor_to_tolerance(const NodeValues& d, const NodeValues& beside_rows,
                                                const NodeBlocks& blocks, bool renew);
  /// `must_be_definite`: that it is, is known; a solver that finds it is not hands on to a
  /// factorisation.
  [[nodiscard]] std::string solve_to_tolerance(double tolerance, bool must_be_definite,
                                               const NodeVectors& b, NodeVectors& x);
  /// Who solves, and why: to a tolerance, and where there was a factorisation, by it; "" until
  /// then.
  [[nodiscard]] const std::string& choice() const { return choice_; }
  /// Iterations of the last solve_to_tolerance; 0 where it was exact.
  [[nodiscard]] long iterations() const { return iterations_; }

  /// Tᵀ(K + diag(d))T, for eigenvalues.
  [[nodiscard]] const SparseMatrix& reduced(const NodeValues& d);

 private:
  void choose_block_solver();

  Unknowns unknowns_;
  const BlockMatrix* pattern_;
  Entries entries_;
  SolverSource source_;
  std::optional<ReducedMatrix> matrix_;  // made when first needed, as all that follows
  std::optional<SolverQueue> solvers_;
  Named<LinearSolver> iterative_;  // null where none suits
  bool has_chosen_ = false;
  std::string choice_;
  Whole whole_;
  NodeValues d_;                 // that the iterative solver has, in case that it cannot
  bool is_handed_over_ = false;  // the matrix that is there, to a factorisation
  long iterations_ = 0;
};

}  // namespace deform
