/// Constraints: a reduction r = T q + b of the degrees of freedom.
#pragma once

#include <array>
#include <vector>

#include "deform/plugin/descriptor.h"
#include "deform/types.h"

namespace deform {

/// Which components of which nodes are prescribed. Constraints add to it once, when a simulation is
/// made; T then selects what is left.
class DEFORM_API Reduction {
 public:
  explicit Reduction(Index nodes);
  /// Prescribes component c (0: x, 1: y, 2: z) of a node. Prescribing it twice is fine: the later
  /// constraint in the scene gives the value. Throws Error when there is no such node or component.
  void prescribe(Index node, int component);
  [[nodiscard]] bool prescribed(Index node, int component) const {
    return prescribed_[static_cast<std::size_t>(component)][static_cast<std::size_t>(node)] != 0;
  }
  [[nodiscard]] Index nodes() const { return nodes_; }
  /// The free nodes of a component, ascending.
  [[nodiscard]] std::vector<Index> free_nodes(int component) const;

 private:
  Index nodes_;
  std::array<std::vector<std::uint8_t>, 3> prescribed_;
};

/// Takes degrees of freedom away and says where they are at any time.
class DEFORM_API Constraint : public Plugin {
 public:
  static constexpr PluginKind kKind = PluginKind::constraint;
  ~Constraint() override;

  virtual void reduce(Reduction& reduction) const = 0;
  /// Writes the prescribed components [m] at a time [s]; leaves the others alone. A pure function
  /// of time.
  virtual void prescribe(double time, NodeVectors& r) const = 0;
};

}  // namespace deform
