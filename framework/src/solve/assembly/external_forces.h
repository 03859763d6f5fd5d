/// The force fields of a model, as a whole.
#pragma once

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "deform/solve/block_matrix.h"
#include "deform/solve/system.h"

namespace deform {

class ExternalForces {
 public:
  ExternalForces(const ModelParts& parts);

  [[nodiscard]] bool needs_normals() const { return needs_normals_; }
  [[nodiscard]] bool needs_neighbours() const { return needs_neighbours_; }
  [[nodiscard]] const std::vector<Named<ForceField>>& fields() const { return forces_; }

  // Each of these is of all fields, or of the `only` one.

  /// f += forces at a state; normals (N × 3) only where needed.
  void add_force(const State& state, const NodeVectors& normals, NodeVectors& f,
                 const Named<ForceField>* only = nullptr);
  /// Adds the scalar tangents, or what bounds them, of those that have any [N/m], [N·s/m]; but no
  /// bounds in place of an exact damping when `spares_exact`.
  void add_tangent(const State& state, const NodeVectors& normals, NodeValues& stiffness,
                   NodeValues& damping, const Named<ForceField>* only = nullptr,
                   bool spares_exact = false);
  /// Calls visit(a, b), a ≤ b, for every pair of nodes that a tangent links.
  template <class Visit>
  void visit_pattern(const Visit& visit) const {
    for (const auto& pairs : pairs_)
      for (const auto& [a, b] : pairs) visit(a, b);
  }
  /// K −= ∂f/∂r + rate ∂f/∂v of those that know them; rate: dv/dr [1/s].
  void add_exact_tangent(const State& state, const NodeVectors& normals, double rate,
                         BlockMatrix& k, const Named<ForceField>* only = nullptr);
  /// K −= ∂f/∂r and f += force of those with a potential that have a stiffness; returns whether
  /// there are any.
  bool add_conservative_stiffness(const State& state, const NodeVectors& normals, BlockMatrix& k,
                                  NodeVectors& f);
  /// Whether that may be anything.
  [[nodiscard]] bool has_exact_tangent() const {
    return std::ranges::any_of(
        traits_, [](const ForceTraits& t) { return t.exact_tangent || t.exact_damping; });
  }
  /// Names of the fields that a Newton step knows no tangent of, though they depend on the surface
  /// around a node (a field that reads the node's own position alone and offers no tangent counts
  /// as constant); and of those without a potential.
  [[nodiscard]] std::vector<std::string> without_tangent() const;
  [[nodiscard]] std::vector<std::string> without_potential() const;

  /// (N) Potential energy at each node [J], until the next call.
  [[nodiscard]] const NodeValues& potential(const State& state, const NodeVectors& normals,
                                            const Named<ForceField>* only = nullptr);

 private:
  template <class Visit>
  void visit_blocks(const State& state, const NodeVectors& normals, const Named<ForceField>* only,
                    const Visit& visit);

  [[nodiscard]] NodeBlock block_of(const State& state, const NodeVectors& normals, Index first,
                                   Index size) const;

  const std::vector<Named<ForceField>> forces_;
  std::vector<ForceTraits> traits_;
  std::vector<std::vector<std::pair<Index, Index>>> pairs_;  // of each field
  std::vector<Eigen::Matrix3d> blocks_, damping_blocks_;
  const NodeValues areas_;
  const NodeValues mass_;
  bool needs_normals_ = false, needs_neighbours_ = false;
  NodeValues potential_;
};

}  // namespace deform
