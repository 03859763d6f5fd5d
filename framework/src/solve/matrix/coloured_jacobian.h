/// The derivative of the force by differences, many columns at a time.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "deform/model/reduction.h"
#include "deform/solve/model_parts.h"
#include "deform/solve/sparse_matrix.h"

#include "solve/matrix/solver_queue.h"
#include "solve/matrix/unknowns.h"

namespace deform {

/// −∂(Tᵀf)/∂q: unknowns whose columns share no row are moved together (Curtis, Powell & Reid 1974).
class ColouredJacobian {
 public:
  /// `dependence`: node by node, those whose positions its force depends on, ascending.
  ColouredJacobian(const ReductionMap& map,
                   const std::vector<std::vector<std::int32_t>>& dependence,
                   const std::vector<Freedom>& held, SolverSource solvers);

  using ForceAt = std::function<const NodeVectors&(const NodeVectors& r)>;
  void differentiate(const NodeVectors& r, const ForceAt& force_at);
  /// With d (N) added to the diagonal; "" or why it cannot be factorised.
  [[nodiscard]] std::string factor(const NodeValues& d);
  [[nodiscard]] std::string solve(const NodeVectors& b, NodeVectors& x);
  /// Who solves, and why; "" until there was something to factorise.
  [[nodiscard]] const std::string& choice() const { return choice_; }

 private:
  void make_pattern(const std::vector<std::vector<std::int32_t>>& dependence);
  void make_colours();

  const ReductionMap* map_;
  Unknowns unknowns_;
  SolverSource source_;
  SparseMatrix jacobian_;
  SparseMatrix shifted_;
  std::vector<std::vector<Index>> colours_;  // unknowns
  std::optional<SolverQueue> solvers_;
  std::string choice_;
};

}  // namespace deform
