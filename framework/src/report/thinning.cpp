#include "report/thinning.h"

#include <algorithm>
#include <array>
#include <cstdint>

#include "report/shown_moments.h"

namespace deform {
namespace {

/// What a picture, a film and a preview need.
struct Least {
  std::size_t nodes, frames, fields;
};
constexpr std::array<Least, 4> kLeast{
    {{5000, 50, static_cast<std::size_t>(-1)}, {2000, 25, 0}, {400, 10, 0}, {80, 2, 0}}};

std::size_t frames_of(std::size_t frames, std::size_t moments, std::size_t stride) {
  const auto kept = every(stride, moments);
  return static_cast<std::size_t>(
      std::ranges::count_if(kept, [frames](std::size_t i) { return i < frames; }));
}

}  // namespace

std::size_t bytes_of(const ReportExtent& extent, const Thinning& thinning) {
  const std::size_t nodes = extent.nodes(thinning.node_stride);
  // Parameters, number, four corners.
  std::size_t bytes = nodes * (2 * sizeof(float) + 5 * sizeof(std::uint32_t));
  for (std::size_t v = 0; v < std::min(thinning.shapes, extent.variants.size()); ++v) {
    const ReportExtent::Variant& variant = extent.variants[v];
    const auto fields = static_cast<std::size_t>(std::ranges::count_if(
        variant.fields, [&thinning](std::size_t field) { return field < thinning.fields; }));
    bytes += frames_of(variant.frames, extent.moments, thinning.frame_stride) * nodes *
             (3 + fields) * sizeof(std::uint16_t);
  }
  return bytes / 3 * 4 + 4;
}

Thinning choose_thinning(const ReportExtent& extent, std::size_t bytes) {
  Thinning t{1, 1, extent.fields, extent.variants.size()};
  const auto fits = [&] { return bytes_of(extent, t) <= bytes; };
  for (const Least& least : kLeast) {
    for (;;) {
      if (fits()) return t;
      const std::size_t nodes = extent.nodes(t.node_stride + 1);
      if (nodes < extent.nodes(t.node_stride) && nodes >= least.nodes) {
        ++t.node_stride;
        continue;
      }
      if (every(t.frame_stride + 1, extent.moments).size() >= least.frames &&
          t.frame_stride < extent.moments) {
        ++t.frame_stride;
        continue;
      }
      if (t.fields == 0 || least.fields >= extent.fields) break;
      --t.fields;
    }
  }
  while (t.shapes > 0 && !fits()) --t.shapes;
  return t;
}

}  // namespace deform
