/// The reduction r = T q + b of the degrees of freedom by constraints.
#pragma once

#include <array>
#include <vector>

#include "deform/export.h"
#include "deform/types.h"

namespace deform {

/// A component (0: x, 1: y, 2: z) of a node's position.
struct Freedom {
  Index node = 0;
  int component = 0;
  bool operator==(const Freedom&) const = default;
};

/// A component that follows others: r = Σ coefficient · r(of) + offset.
struct Tie {
  struct Part {
    Freedom of;
    double coefficient = 0;
  };
  Freedom freedom;
  std::vector<Part> parts;
  double offset = 0;  ///< [m]
};

/// Which components of which nodes are prescribed, and which are tied to others; q is what is left.
/// Constraints add to it once, when a simulation is made. A component that is prescribed is not
/// tied, whoever says so first; one that is tied twice keeps the first tie (where two edges meet,
/// those of both hold then, as they do for products of differences along each).
class DEFORM_API Reduction {
 public:
  explicit Reduction(Index nodes);
  /// Prescribes component c (0: x, 1: y, 2: z) of a node. Prescribing it twice is fine: the later
  /// constraint in the scene gives the value. Throws Error when there is no such node or component.
  void prescribe(Index node, int component);
  /// Ties a component to others, which may be prescribed or tied themselves. Throws Error when
  /// there is no such node or component.
  void tie(const Tie& tie);
  /// Makes it that of the world reflected at z = 0: changes the signs of what links z with x or y,
  /// and of offsets of z. Done twice, it changes nothing.
  void reflect();

  [[nodiscard]] bool prescribed(Index node, int component) const {
    return kind(node, component) == Kind::prescribed;
  }
  [[nodiscard]] bool free(Index node, int component) const {
    return kind(node, component) == Kind::free;
  }
  [[nodiscard]] Index nodes() const { return nodes_; }
  /// The free nodes of a component, ascending.
  [[nodiscard]] std::vector<Index> free_nodes(int component) const;
  /// The ties that hold, each behind those that it needs. Throws InputError when they go in
  /// circles.
  [[nodiscard]] std::vector<Tie> ties() const;
  /// Whether some tie makes a component follow another component (x follow z, say).
  [[nodiscard]] bool ties_mix_components() const;

 private:
  enum class Kind : std::uint8_t { free, prescribed, tied };
  [[nodiscard]] Kind kind(Index node, int component) const {
    return kind_[static_cast<std::size_t>(component)][static_cast<std::size_t>(node)];
  }
  void require(Index node, int component, const char* verb) const;

  Index nodes_;
  std::array<std::vector<Kind>, 3> kind_;
  std::vector<Tie> ties_;  // in the order of being made, those of prescribed components included
};

/// T and b at work, in arrays over all nodes.
class DEFORM_API ReductionMap {
 public:
  explicit ReductionMap(const Reduction& reduction);
  /// Writes the tied components of positions, or of their changes (without the offsets).
  void complete_positions(NodeVectors& r) const { complete(r, true); }
  void complete_changes(NodeVectors& dr) const { complete(dr, false); }
  /// Tᵀf in place (N × 3): what acts on tied components goes to those that they follow, what acts
  /// on prescribed ones is dropped.
  void transpose(NodeVectors& f) const;
  /// A row of T: free components with their coefficients.
  using Row = std::vector<Tie::Part>;
  /// Empty for prescribed components.
  [[nodiscard]] Row row(const Freedom& freedom) const;
  [[nodiscard]] const std::vector<Tie>& ties() const { return ties_; }
  [[nodiscard]] const Reduction& reduction() const { return reduction_; }

 private:
  void complete(NodeVectors& r, bool with_offsets) const;

  Reduction reduction_;
  std::vector<Tie> ties_;
  std::vector<Row> rows_;                            // of the ties
  std::array<std::vector<std::int32_t>, 3> number_;  // of a component's tie, or −1
};

}  // namespace deform
