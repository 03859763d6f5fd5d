/// What making matrices spends its time with, on raw arrays: entries of four rows at once, as they
/// lie in Quads, and blocks that go to both triangles.
#pragma once

#include <array>
#include <compare>

#include "quads.h"

namespace multigrid {

/// An entry of a row of PᵀA, and the weight with which it is part of one of PᵀAP.
struct Share {
  std::uint16_t from = 0;
  float weight = 0;
  auto operator<=>(const Share&) const = default;
};

/// Four rows, whose entries follow each other by fours from these on.
using FourRows = std::array<const float*, kQuad>;

/// Adds `size` entries of four rows, times a weight, to those of `to` at slot[0], slot[1], …, whose
/// entries are 4 numbers, or, for blocks, 48: three columns of four rows with four lanes.
void add_scalars(float weight, const FourRows& from, const std::uint16_t* slot, Index size,
                 float* to);
void add_blocks(float weight, const FourRows& from, const std::uint16_t* slot, Index size,
                float* to);

/// sums[k] = Σ weight · t[from] over the shares before share[end[k]] that k − 1 has not, for each
/// of `size` entries of four rows.
void combine_scalars(const Share* share, const std::uint16_t* end, Index size, const float* t,
                     float* sums);
void combine_blocks(const Share* share, const std::uint16_t* end, Index size, const float* t,
                    float* sums);

/// Where the block at a place begins: its columns of four lanes lie 16 numbers apart.
[[nodiscard]] inline std::size_t start_of_block(std::int32_t place) {
  const auto p = static_cast<std::size_t>(place);
  return 48 * (p / 4) + 4 * (p % 4);
}
/// Writes `size` blocks of a row, 9 numbers each, row-major, to the places `upper`, and their
/// transposes to `lower`, each with fourth lanes of 0.
void write_blocks(const double* blocks, const std::int32_t* upper, const std::int32_t* lower,
                  Index size, float* value);

}  // namespace multigrid
