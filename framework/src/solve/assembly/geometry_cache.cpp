#include "solve/assembly/geometry_cache.h"

#include <algorithm>

namespace deform {
namespace {

/// One of a step's start and one of its end.
constexpr std::size_t kLeast = 2;

}  // namespace

std::shared_ptr<StateGeometry> GeometryCache::find(const NodeVectors& r) {
  for (Slot& slot : slots_) {
    if (!slot.is_known || slot.geometry->r.rows() != r.rows() || slot.geometry->r != r) continue;
    slot.used = ++uses_;
    return slot.geometry;
  }
  return nullptr;
}

std::shared_ptr<StateGeometry> GeometryCache::room() {
  Slot* oldest = nullptr;
  for (Slot& slot : slots_)
    if (slot.geometry.use_count() == 1 && (oldest == nullptr || slot.used < oldest->used))
      oldest = &slot;
  if (oldest == nullptr || slots_.size() < kLeast) {
    slots_.push_back({std::make_shared<StateGeometry>(), false, 0});
    return slots_.back().geometry;
  }
  oldest->is_known = false;
  return oldest->geometry;
}

void GeometryCache::keep(const std::shared_ptr<StateGeometry>& geometry, const NodeVectors& r) {
  const auto slot = std::ranges::find(slots_, geometry, &Slot::geometry);
  geometry->r = r;
  slot->is_known = true;
  slot->used = ++uses_;
}

}  // namespace deform
