/// The unknowns q of a Newton step, among the components of all nodes.
#pragma once

#include <cstdint>
#include <vector>

#include "deform/model/reduction.h"
#include "deform/types.h"

#include "solve/matrix/reduced_matrix.h"

namespace deform {

/// Free components that are not held, node by node, x, y, z: what belongs together is close in a
/// matrix.
class Unknowns {
 public:
  /// `held`: free components that stay where they are.
  Unknowns(const ReductionMap& map, const std::vector<Freedom>& held);

  /// Whether some component follows others that are free.
  [[nodiscard]] bool has_ties() const { return !map_->ties().empty(); }
  /// (N) Bit c: component c of the node is no unknown.
  [[nodiscard]] std::vector<std::uint8_t> held() const;
  [[nodiscard]] Index size() const { return static_cast<Index>(freedom_of_.size()); }
  [[nodiscard]] const Freedom& operator[](Index unknown) const {
    return freedom_of_[static_cast<std::size_t>(unknown)];
  }
  /// A component's row of T; empty where it is prescribed or follows only what is held.
  [[nodiscard]] std::vector<ReducedMatrix::Part> row(const Freedom& freedom) const;

  /// The entries of a field (N × 3) at the unknowns.
  [[nodiscard]] Eigen::VectorXd gathered(const NodeVectors& field) const;
  /// Those of Tᵀf, for forces f (N × 3).
  [[nodiscard]] Eigen::VectorXd reduced(NodeVectors f) const;
  /// T y (N × 3).
  [[nodiscard]] NodeVectors expanded(const Eigen::VectorXd& y) const;

 private:
  const ReductionMap* map_;
  std::vector<Freedom> freedom_of_;
  std::vector<Index> number_;  // of each component among the unknowns, or −1
};

}  // namespace deform
