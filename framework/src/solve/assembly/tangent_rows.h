/// Rows of a tangent from second derivatives at samples: Σ_mn D_mᵀ A h_mn D_n.
#pragma once

#include <compare>
#include <cstdint>
#include <vector>

#include "deform/model/tangent.h"
#include "deform/types.h"

namespace deform {

/// How a row is made of its samples' numbers. A part is row a of Σ_m D_mᵀ A h_mn at one sample, for
/// one derivative n; each block of the row is a sum of parts times the rows of D_n. Rows of equal
/// plans differ in where their samples' numbers are.
struct TangentPlan {
  struct Left {
    std::int16_t block;  // adds l times that block, or its transpose
    bool is_transposed;
    double l;
    auto operator<=>(const Left&) const = default;
  };
  struct Part {
    std::uint32_t sample, left_end;
    auto operator<=>(const Part&) const = default;
  };
  struct Right {
    std::uint32_t part;
    double d;
    auto operator<=>(const Right&) const = default;
  };

  std::vector<Left> left;
  std::vector<Part> parts;               // ascending by sample
  std::vector<Right> right;              // ascending by part for each block
  std::vector<std::uint32_t> right_end;  // of each block of the row
  std::size_t samples = 0;
  /// Some order, so that equal plans can be found.
  auto operator<=>(const TangentPlan&) const = default;
};

/// Rows that are made at once.
inline constexpr Index kRowLanes = 32;
/// From a number of a sample's second derivatives to its next: so many samples, side by side, and
/// some room.
inline constexpr Index kSampleLanes = kRowLanes + 8;

/// What a sample's numbers are: nine for each block of second derivatives; or one, c_mn, and, where
/// the blocks are c_mn n nᵀ, after all of these the three of the normal n.
struct SampleNumbers {
  const double* h;
  const std::uint32_t* places;  ///< of a plan's samples
  TangentShape shape;
  Index blocks;  ///< a sample
};
/// Numbers that making rows needs room for.
[[nodiscard]] std::size_t room_for(const TangentPlan& plan);
/// Makes `size` rows, at most kRowLanes, number q of the k-th at rows[q·kRowLanes + k], or `adds`
/// to them; the k-th row's sample e has its number q at h[places[e] + k + q·kSampleLanes]. Writes
/// the lanes behind them, too. Returns whether all rows are finite.
[[nodiscard]] bool make_rows(const TangentPlan& plan, const SampleNumbers& of, bool adds,
                             Index size, double* room, double* rows);
/// Moves rows that lie side by side, as above, to where each is whole: the k-th to to[k]; or adds
/// them to what is there. Returns whether all of these numbers are finite.
[[nodiscard]] bool store_rows(const double* rows, Index size, Index numbers, double* const* to,
                              bool adds);
/// Makes one row, or adds to it.
[[nodiscard]] bool make_row(const TangentPlan& plan, const SampleNumbers& of, bool adds,
                            double* room, double* row);
/// Moves one row.
[[nodiscard]] bool store_row(const double* row, Index numbers, double* to, bool adds);

}  // namespace deform
