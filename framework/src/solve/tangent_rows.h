/// Rows of a tangent from second derivatives at samples: Σ_mn D_mᵀ A h_mn D_n.
#pragma once

#include <algorithm>
#include <cstdint>
#include <tuple>
#include <vector>

#include "deform/types.h"

namespace deform {

/// How a row is made of its samples' numbers: row a of Σ_m D_mᵀ A h_mn for each derivative n, times
/// the rows of D_n. Rows of equal plans differ in where their samples' numbers are.
struct TangentPlan {
  struct Left {
    std::int16_t n, block;         // adds l times that block, or its transpose
    bool is_transposed, is_first;  // first: of that n, at the sample
    double l;
    [[nodiscard]] auto key() const { return std::tie(n, block, is_transposed, is_first, l); }
  };
  struct Right {
    std::int16_t n, slot;  // slot: of a block in the row
    double d;
    [[nodiscard]] auto key() const { return std::tie(n, slot, d); }
  };
  struct Sample {
    std::uint32_t left, left_end, right, right_end;
    [[nodiscard]] auto key() const { return std::tie(left, left_end, right, right_end); }
  };

  std::vector<Left> left;
  std::vector<Right> right;
  std::vector<Sample> samples;

  /// Some order, so that equal plans can be found.
  friend bool operator<(const TangentPlan& a, const TangentPlan& b) {
    const auto is_before = [](const auto& x, const auto& y) {
      return std::ranges::lexicographical_compare(
          x, y, [](const auto& p, const auto& q) { return p.key() < q.key(); });
    };
    if (is_before(a.samples, b.samples)) return true;
    if (is_before(b.samples, a.samples)) return false;
    if (is_before(a.right, b.right)) return true;
    if (is_before(b.right, a.right)) return false;
    return is_before(a.left, b.left);
  }
};

/// Rows that are made at once.
inline constexpr Index kRowLanes = 32;
/// From a number of a sample's second derivatives to its next: so many samples, side by side, and
/// some room.
inline constexpr Index kSampleLanes = kRowLanes + 8;

/// Adds to kRowLanes rows, number q of the k-th at rows[q·kRowLanes + k]; the k-th row's sample e
/// has its number q at h[places[e] + k + q·kSampleLanes].
void add_to_rows(const TangentPlan& plan, const double* h, const std::uint32_t* places,
                 double* rows);
/// Moves rows that lie side by side, as above, to where each is whole: the k-th to to[k]; or adds
/// them to what is there. Returns whether all of these numbers are finite.
[[nodiscard]] bool store_rows(const double* rows, Index size, Index numbers, double* const* to,
                              bool adds);
/// Adds to one row.
void add_to_row(const TangentPlan& plan, const double* h, const std::uint32_t* places, double* row);
/// Whether some numbers of rows that lie side by side, as above, are finite.
[[nodiscard]] bool rows_are_finite(const double* rows, Index size, Index numbers, Index lanes);
/// Moves one row.
[[nodiscard]] bool store_row(const double* row, Index numbers, double* to, bool adds);

}  // namespace deform
