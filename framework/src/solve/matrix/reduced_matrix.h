/// TᵀAT: a matrix on the free degrees of freedom, gathered from one on all.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "deform/solve/sparse_matrix.h"
#include "deform/types.h"

namespace deform {

/// Made once a pattern; then `fill` as often as the values change.
class ReducedMatrix {
 public:
  struct Part {
    Index unknown = 0;
    double coefficient = 0;
  };
  /// Row of T of each degree of freedom: empty where it is prescribed.
  using Rows = std::vector<std::vector<Part>>;
  /// visit(i, j, place): entry (i, j) of A and where its value is kept.
  using Visit = std::function<void(Index i, Index j, Index place)>;
  /// Calls a Visit for each entry of A, diagonal entries included, always in the same order.
  using VisitEntries = std::function<void(const Visit&)>;

  /// `components`: degrees of freedom a node, one after another.
  ReducedMatrix(Index unknowns, const Rows& rows, Index components,
                const VisitEntries& visit_entries);

  /// The values of Tᵀ(A + diag(d))T; d (N) is the same for all components of a node.
  void fill(const std::vector<double>& values, const NodeValues& d);
  [[nodiscard]] const SparseMatrix& matrix() const { return matrix_; }

 private:
  struct Extra {
    std::int32_t target = 0;
    std::int32_t source = 0;  // place of A's value, or node of d
    double coefficient = 0;
  };
  void make_pattern(Index unknowns, const Rows& rows, const VisitEntries& visit_entries);
  [[nodiscard]] std::int32_t place_of(Index row, Index column) const;

  SparseMatrix matrix_;
  std::vector<std::int32_t> source_;         // place of A's value, of each value; −1 for none
  std::vector<std::int32_t> diagonal_;       // place of the diagonal value of each unknown …
  std::vector<std::int32_t> node_;           // … and its node
  std::vector<Extra> tied_, tied_diagonal_;  // what ties add
};

}  // namespace deform
