/// The moments that a report shows: its variants at the same times.
#pragma once

#include <cstddef>
#include <vector>

#include "deform/record/trajectory.h"

namespace deform {

struct ShownMoments {
  std::vector<Moment> moments;
  /// For each variant the frames of its trajectory at the first of these moments, as far as it got.
  std::vector<std::vector<std::size_t>> frames;
  std::size_t recorded = 0;  ///< moments of the variant that they are taken from
};

/// The moments of the variant that got farthest (the first of those; `last_choice` only where there
/// is no other) that all others which reached that time have, too. Each variant's moments ascend;
/// those of one without a trajectory are empty.
[[nodiscard]] ShownMoments shown_moments(const std::vector<std::vector<Moment>>& variants,
                                         std::size_t last_choice);

/// Every `stride`-th of `count` numbers from 0, and the last.
[[nodiscard]] std::vector<std::size_t> every(std::size_t stride, std::size_t count);

/// Leaves every `stride`-th moment, and the last.
[[nodiscard]] ShownMoments every(std::size_t stride, const ShownMoments& all);

}  // namespace deform
