/// Multigrid cycles over a hierarchy of levels, as preconditioner of the finest level's matrix.
#pragma once

#include <deque>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include "galerkin.h"
#include "level.h"

namespace multigrid {

/// What is done on the finest level, where a pass over the matrix costs most.
enum class Finest {
  additive,  ///< ω D⁻¹ f + P x₁: no pass over the matrix
  smoothed,  ///< steps before and after the coarse correction, as on all other levels: two passes
};

template <class Entry>
class Cycle {
 public:
  /// `held`: nodes with held components, ascending; `coarsening`: from fine to coarse.
  Cycle(const Pattern& finest, std::vector<Held> held,
        const std::vector<deform::Prolongation>& coarsening, Finest treatment);
  Cycle(const Cycle&) = delete;
  Cycle& operator=(const Cycle&) = delete;

  [[nodiscard]] Level<Entry>& finest() { return levels_.front(); }
  /// The values of the finest level are there: makes ready what it takes to step on it …
  void renew_finest();
  /// … and makes those of the others.
  void renew_coarse();
  /// x of the finest level from its f: one cycle. Returns f·x.
  [[nodiscard]] double run();
  /// The same without the coarse levels: x = ω D⁻¹ f.
  [[nodiscard]] double step();

 private:
  void factor_coarsest();
  void solve_coarsest();
  void run_from(std::size_t level);
  void correct_from_coarser(std::size_t level);

  std::deque<Level<Entry>> levels_;  // their products refer to their strips
  std::vector<Galerkin> between_;    // level and the next
  Finest treatment_;
  Sums sums_;  // of f·x on the finest level
  Eigen::MatrixXd coarsest_, exact_inverse_;
  Eigen::LLT<Eigen::MatrixXd> factor_;
  Eigen::MatrixXf inverse_;  // of the coarsest level
  Eigen::VectorXf f_, x_;
};

}  // namespace multigrid
