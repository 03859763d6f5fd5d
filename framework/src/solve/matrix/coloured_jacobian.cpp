#include "solve/matrix/coloured_jacobian.h"

#include <algorithm>
#include <utility>

#include "deform/geometry/characteristic_length.h"

#include "no_solver.h"
#include "solve/assembly/pattern.h"
#include "solve/matrix/difference_step.h"

namespace deform {
ColouredJacobian::ColouredJacobian(const ReductionMap& map,
                                   const std::vector<std::vector<std::int32_t>>& dependence,
                                   const std::vector<Freedom>& held, SolverSource solvers)
    : map_(&map), unknowns_(map, held), source_(std::move(solvers)) {
  make_pattern(dependence);
  make_colours();
}

/// Row p, column q where the reduced force on p depends on q, through ties on either side; made
/// symmetric, as solvers want it.
void ColouredJacobian::make_pattern(const std::vector<std::vector<std::int32_t>>& dependence) {
  const auto unknowns_of = [&](Index node) {
    std::vector<Index> unknowns;
    for (int c = 0; c < 3; ++c)
      for (const ReducedMatrix::Part& part : unknowns_.row({node, c}))
        unknowns.push_back(part.unknown);
    return unknowns;
  };
  std::vector<std::vector<Index>> of_node;
  for (std::size_t a = 0; a < dependence.size(); ++a)
    of_node.push_back(unknowns_of(static_cast<Index>(a)));
  PatternBuilder pattern(unknowns_.size());
  for (std::size_t a = 0; a < dependence.size(); ++a)
    for (const std::int32_t b : dependence[a])
      for (const Index p : of_node[a])
        for (const Index q : of_node[static_cast<std::size_t>(b)]) pattern.add(p, q);
  jacobian_ = pattern.build();
}

/// Greedily: unknowns of one colour have no row in common.
void ColouredJacobian::make_colours() {
  const auto unknowns = static_cast<std::size_t>(jacobian_.size);
  std::vector<std::vector<char>> taken;  // rows, a colour
  for (std::size_t q = 0; q < unknowns; ++q) {
    const auto begin = jacobian_.column.begin() + jacobian_.row_begin[q];
    const auto end = jacobian_.column.begin() + jacobian_.row_begin[q + 1];
    std::size_t colour = 0;
    const auto clashes = [&] {
      return std::any_of(
          begin, end, [&](std::int32_t p) { return taken[colour][static_cast<std::size_t>(p)]; });
    };
    while (colour < taken.size() && clashes()) ++colour;
    if (colour == taken.size()) {
      taken.emplace_back(unknowns, 0);
      colours_.emplace_back();
    }
    colours_[colour].push_back(static_cast<Index>(q));
    for (auto p = begin; p != end; ++p) taken[colour][static_cast<std::size_t>(*p)] = 1;
  }
}

void ColouredJacobian::differentiate(const NodeVectors& r, const ForceAt& force_at) {
  const double step = kDifferenceStep * characteristic_length(r);
  std::ranges::fill(jacobian_.value, 0.0);
  NodeVectors direction(r.rows(), 3), change(r.rows(), 3);
  for (const std::vector<Index>& colour : colours_) {
    direction.setZero();
    for (const Index q : colour) {
      const Freedom& f = unknowns_[q];
      direction(f.node, f.component) = step;
    }
    map_->complete_changes(direction);
    change = force_at(r - direction);
    change -= force_at(r + direction);
    change /= 2 * step;
    map_->transpose(change);
    for (const Index q : colour)
      for (std::int32_t k = jacobian_.row_begin[static_cast<std::size_t>(q)];
           k < jacobian_.row_begin[static_cast<std::size_t>(q) + 1]; ++k) {
        const std::int32_t p = jacobian_.column[static_cast<std::size_t>(k)];
        const auto begin =
            jacobian_.column.begin() + jacobian_.row_begin[static_cast<std::size_t>(p)];
        const auto end =
            jacobian_.column.begin() + jacobian_.row_begin[static_cast<std::size_t>(p) + 1];
        const auto place =
            std::lower_bound(begin, end, static_cast<std::int32_t>(q)) - jacobian_.column.begin();
        const Freedom& f = unknowns_[p];
        jacobian_.value[static_cast<std::size_t>(place)] = change(f.node, f.component);
      }
  }
}

std::string ColouredJacobian::factor(const NodeValues& d) {
  try {
    if (!solvers_)
      solvers_.emplace(source_, MatrixTraits{.size = jacobian_.size, .symmetric = false});
    if (choice_.empty()) choice_ = solvers_->choice(jacobian_);
  } catch (const NoSolver& e) {  // a direction less, where there are others
    return e.what();
  }
  shifted_ = jacobian_;
  for (std::size_t q = 0; q < static_cast<std::size_t>(unknowns_.size()); ++q) {
    const auto begin = shifted_.column.begin() + shifted_.row_begin[q];
    const auto end = shifted_.column.begin() + shifted_.row_begin[q + 1];
    const auto place =
        std::lower_bound(begin, end, static_cast<std::int32_t>(q)) - shifted_.column.begin();
    shifted_.value[static_cast<std::size_t>(place)] += d[unknowns_[static_cast<Index>(q)].node];
  }
  return solvers_->factor(shifted_);
}

std::string ColouredJacobian::solve(const NodeVectors& b, NodeVectors& x) {
  return solvers_->solve(unknowns_, b, x);
}

}  // namespace deform
