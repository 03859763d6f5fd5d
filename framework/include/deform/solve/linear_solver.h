/// Linear solvers for A X = B with a few right-hand sides.
#pragma once

#include <string>

#include "deform/plugin/descriptor.h"
#include "deform/solve/sparse_matrix.h"
#include "deform/types.h"

namespace deform {

/// Contract: `analyse` once a pattern, then any number of `factor` and `solve`; the same input
/// gives the same bits. Not thread-safe: one object a matrix.
class DEFORM_API LinearSolver : public Plugin {
 public:
  static constexpr PluginKind kKind = PluginKind::solver;
  ~LinearSolver() override;

  /// How well it suits such matrices: 0 not at all; the framework takes the highest when the scene
  /// is silent.
  [[nodiscard]] virtual double suitability(const MatrixTraits& traits) const = 0;
  /// Looks at the pattern (and size) of A; values do not matter.
  virtual void analyse(const SparseMatrix& a, const MatrixTraits& traits) = 0;
  /// Prepares to solve with the values of A. Returns "" or why it cannot (e.g. not positive
  /// definite); the framework then tries another solver.
  [[nodiscard]] virtual std::string factor(const SparseMatrix& a) = 0;
  /// (n × k) right-hand sides to solutions; both column-major, not the same memory.
  virtual void solve(const Eigen::Ref<const Eigen::MatrixXd>& b, Eigen::Ref<Eigen::MatrixXd> x) = 0;
};

}  // namespace deform
