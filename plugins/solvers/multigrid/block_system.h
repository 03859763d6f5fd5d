/// Newton's systems: matrices of 3 × 3 blocks in single precision.
#pragma once

#include <optional>

#include <deform/solve/linear_solver.h>

#include "conjugate_gradients.h"
#include "cycle.h"

namespace multigrid {

/// Single precision serves where a direction need not be exact: it halves what has to be read.
///
/// Where inertia outweighs what the coarse levels would be good for (small steps, few nodes, loose
/// tolerances), the diagonal blocks alone precondition: an iteration costs a seventh of a cycle's,
/// and there are no coarse matrices to make.
class BlockSystem {
 public:
  /// Iterations at most; after the first `patience` of them an old preconditioner is made anew.
  struct Limits {
    int iterations = 100, patience = 6;
  };
  BlockSystem(const deform::BlockMatrix& pattern, const std::vector<std::uint8_t>& held,
              const std::vector<deform::Prolongation>& coarsening, Limits limits);

  void put(const deform::BlockRows& rows);
  void factor(const deform::NodeValues& d, const deform::NodeBlocks& blocks, bool renew);
  [[nodiscard]] deform::Outcome solve(const deform::NodeVectors& b, double tolerance,
                                      deform::NodeVectors& x);
  [[nodiscard]] int iterations() const { return iterations_; }

 private:
  void put_in_strip(const deform::BlockRows& rows, Index skipped, Index size);
  [[nodiscard]] Ending iterate(double tolerance, int most, bool with_cycle);
  [[nodiscard]] Ending solve_by_cycles(double tolerance);
  void measure_inertia(const deform::NodeValues& d);
  [[nodiscard]] double iterations_by_diagonal(double tolerance) const;

  Limits limits_;
  Pattern pattern_;
  deform::NodeBlocks diagonal_;  // what `factor` adds to
  std::optional<Cycle<Block>> cycle_;
  ConjugateGradients gradients_;
  Field<float> b_, x_;
  bool wants_new_ = true;    // there are no coarse levels that may be used
  bool is_current_ = false;  // those that there are, are of the matrix that is there
  double inertia_ = 0;       // mean part of d in the diagonal
  int iterations_ = 0;
};

}  // namespace multigrid
