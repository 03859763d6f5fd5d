/// Geometries of the states that were seen last.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "deform/geometry/geometry.h"
#include "deform/types.h"

namespace deform {

/// One state's geometry at all of a surface's sample sets. It stays what it is while anybody but
/// the cache holds it.
struct StateGeometry {
  NodeVectors r;                 ///< (N × 3) positions that it is of
  std::vector<Geometry> of_set;  ///< as far as terms and forces need it, one a set
  NodeVectors normals;           ///< (N × 3) at the nodes, where force fields need them
};

/// By positions: whoever asks for those of a state that was seen a moment ago gets them for
/// nothing. There are as many as anybody holds, two at least; the one that was used longest ago
/// makes room.
class GeometryCache {
 public:
  /// That of r; null where it is not known.
  [[nodiscard]] std::shared_ptr<StateGeometry> find(const NodeVectors& r);
  /// One that nobody uses, which is of no state until it is kept; without geometries where it is
  /// new.
  [[nodiscard]] std::shared_ptr<StateGeometry> room();
  /// `geometry` is that of r from now on.
  void keep(const std::shared_ptr<StateGeometry>& geometry, const NodeVectors& r);

 private:
  struct Slot {
    std::shared_ptr<StateGeometry> geometry;
    bool is_known = false;
    std::uint64_t used = 0;  // when
  };
  std::vector<Slot> slots_;
  std::uint64_t uses_ = 0;
};

}  // namespace deform
