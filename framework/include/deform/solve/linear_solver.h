/// Linear solvers for A X = B with a few right-hand sides.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "deform/plugin/descriptor.h"
#include "deform/solve/block_matrix.h"
#include "deform/solve/sparse_matrix.h"
#include "deform/types.h"

namespace deform {

class BlockSolver;

/// How a factorisation, or an iterative solve, ended.
enum class Outcome : std::uint8_t {
  solved,
  indefinite,  ///< the matrix is not positive definite
  unfinished,  ///< it cannot: too many iterations, no memory, …; another solver may
};

/// What came of a factorisation.
struct Factorisation {
  Outcome outcome = Outcome::solved;
  std::string reason;  ///< why the solver cannot; empty where it can

  Factorisation() = default;
  Factorisation(Outcome o, std::string why) : outcome(o), reason(std::move(why)) {}
  /// From "" or why it cannot, which another solver may.
  Factorisation(std::string why)
      : outcome(why.empty() ? Outcome::solved : Outcome::unfinished), reason(std::move(why)) {}
  Factorisation(const char* why) : Factorisation(std::string(why)) {}
  [[nodiscard]] static Factorisation not_positive_definite(std::string why) {
    return {Outcome::indefinite, std::move(why)};
  }
};

/// Contract: `analyse` once a pattern, then any number of `factor` and `solve`; the same input
/// gives the same bits. Not thread-safe: one object a matrix.
class DEFORM_API LinearSolver : public Plugin {
 public:
  static constexpr PluginKind kKind = PluginKind::solver;
  ~LinearSolver() override;

  /// From here on a solver is taken where the scene is silent.
  static constexpr double kSuitable = 1;
  /// How well it suits such matrices: 0 not at all; the framework takes the highest when the scene
  /// is silent, the next where that one cannot, and one below kSuitable only where there is no
  /// other.
  [[nodiscard]] virtual double suitability(const MatrixTraits& traits) const = 0;
  /// Looks at the pattern (and size) of A; values do not matter.
  virtual void analyse(const SparseMatrix& a, const MatrixTraits& traits) = 0;
  /// Prepares to solve with the values of A. Where it cannot, says why, and whether that is because
  /// A is not positive definite, which Newton's method wants to know; else the framework tries
  /// another solver.
  [[nodiscard]] virtual Factorisation factor(const SparseMatrix& a) = 0;
  /// B to X (n × k, column-major, not the same memory). Error (diverged): it cannot, try another.
  virtual void solve(const Eigen::Ref<const Eigen::MatrixXd>& b, Eigen::Ref<Eigen::MatrixXd> x) = 0;
  /// The same from a guess X: its error, in a norm of the solver's choice, is made smaller to at
  /// most that part of itself, or to what rounding permits. Default: solve.
  virtual void improve(const Eigen::Ref<const Eigen::MatrixXd>& b, double tolerance,
                       Eigen::Ref<Eigen::MatrixXd> x);

  /// This solver's way with matrices of blocks; null where it has none.
  [[nodiscard]] virtual BlockSolver* blocks() { return nullptr; }
};

/// Optional capability of a LinearSolver: solves to a tolerance with symmetric matrices of 3 × 3
/// blocks, as Newton's method makes them, some components of nodes being held.
///
/// Contract: `analyse` once a pattern; then, any number of times, `put` for all rows of A, `factor`
/// with one d and blocks or several in turn, `solve`. What a solution is depends on nothing before
/// the last `factor` that was told to renew but the rows.
class DEFORM_API BlockSolver {
 public:
  virtual ~BlockSolver();

  /// As LinearSolver::suitability, on the same scale.
  [[nodiscard]] virtual double block_suitability(Index nodes) const = 0;
  /// Bit c of held[a]: component c of node a is held at 0 (N).
  virtual void analyse(const BlockMatrix& pattern, const std::vector<std::uint8_t>& held) = 0;
  /// Takes the values of some rows of A. Thread-safe for different rows.
  virtual void put(const BlockRows& rows) = 0;
  /// Prepares to solve with A + diag(d) + blocks, d (N) for x, y and z alike, blocks on the
  /// diagonal (contact's; often none); unless `renew`, what was prepared from earlier values to
  /// solve faster (a preconditioner) may be kept.
  virtual void factor(const NodeValues& d, const NodeBlocks& blocks, bool renew) = 0;
  /// (A + diag(d) + blocks) x = b on what is not held, x (N × 3) with b's error in a norm of the
  /// solver's choice reduced to `tolerance`; x is of no use unless that is what came of it.
  [[nodiscard]] virtual Outcome solve(const NodeVectors& b, double tolerance, NodeVectors& x) = 0;
  /// That the last `solve` took.
  [[nodiscard]] virtual long iterations() const = 0;
};

}  // namespace deform
