/// Shapes: where the nodes are, at rest or at first.
#pragma once

#include "deform/plugin/descriptor.h"
#include "deform/types.h"

namespace deform {

/// Maps the nodes' parameters to positions. `parameters` (N × 2) [m], `size`: extent of the
/// parameter rectangle [m]; returns (N × 3) [m]. Throws InputError when it cannot.
class DEFORM_API Shape : public Plugin {
 public:
  static constexpr PluginKind kKind = PluginKind::shape;
  ~Shape() override;
  [[nodiscard]] virtual NodeVectors positions(const Eigen::MatrixX2d& parameters,
                                              const Vec2& size) const = 0;
};

}  // namespace deform
