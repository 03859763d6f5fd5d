/// How much of what was recorded a report shows.
#pragma once

#include <cstddef>
#include <functional>
#include <vector>

namespace deform {

/// What there is to show.
struct ReportExtent {
  struct Variant {
    std::size_t frames = 0;
    std::vector<std::size_t> fields;  ///< numbers of those that it has
  };
  /// Nodes that stay with each `stride`-th; the same for every stride where none can be left out.
  std::function<std::size_t(std::size_t stride)> nodes;
  std::size_t moments = 0;
  std::size_t fields = 0;  ///< different ones
  std::vector<Variant> variants;
};

struct Thinning {
  std::size_t node_stride = 1;
  std::size_t frame_stride = 1;
  std::size_t fields = 0;  ///< the first of them
  std::size_t shapes = 0;  ///< the first of the variants
};

/// Bytes of text that mesh, positions and fields take.
[[nodiscard]] std::size_t bytes_of(const ReportExtent& extent, const Thinning& thinning);

/// The least thinning with which they take at most so many bytes: nodes go first, as a picture has
/// room for a few thousand; then frames, then fields; then more of all, at last whole variants.
[[nodiscard]] Thinning choose_thinning(const ReportExtent& extent, std::size_t bytes);

}  // namespace deform
