/// Coarser matrices by Galerkin's product PᵀAP.
#pragma once

#include <array>
#include <compare>
#include <vector>

#include <deform/surface/prolongation.h>

#include "alike_rows.h"
#include "level.h"

namespace multigrid {

/// PᵀAP for one P and one pattern of A. Each coarse row is made by itself: its row of T = PᵀA, then
/// that times P. Where the products go is found once, and shared by the rows that are alike.
class Galerkin {
 public:
  Galerkin(const Level<Block>& fine, const deform::Prolongation& p);
  Galerkin(const Level<Scalar>& fine, const deform::Prolongation& p);

  [[nodiscard]] const Pattern& coarse() const { return coarse_; }
  /// The values of PᵀAP; `fine` without its held rows and columns, so that P needs to know of none.
  void multiply(const Level<Block>& fine, Level<Block>& coarse) const;
  void multiply(const Level<Scalar>& fine, Level<Scalar>& coarse) const;
  /// f of the coarse level from the residual r: Pᵀ r.
  void restrict_to(const LaneVector& r, LaneVector& f) const;
  /// (P x)_a.
  [[nodiscard]] Lanes prolonged(Index a, const LaneVector& coarse) const {
    return p_.product(a, coarse);
  }
  /// The coarse node at a fine one, or −1.
  [[nodiscard]] std::int32_t same(Index fine) const;

 private:
  /// An entry of T's row, and the weight with which it is part of one of the coarse row.
  struct Share {
    std::uint16_t from = 0;
    float weight = 0;
    auto operator<=>(const Share&) const = default;
  };
  /// Where the products of a coarse row go.
  struct Plan {
    std::vector<std::uint16_t> slot;  // in T's row, of each entry of each fine row
    std::vector<std::uint16_t> size;  // entries of each fine row
    std::vector<float> weight;        // of each fine row
    std::uint16_t slots = 0;          // of T's row
    std::vector<std::uint16_t> end;   // in `shares`, of each entry of the coarse row
    std::vector<Share> shares;
    auto operator<=>(const Plan&) const = default;
  };
  class Planner;

  void plan(const Pattern& fine, const Quads& quads);
  [[nodiscard]] const Plan& plan_of(Index c) const {
    return plans_[static_cast<std::size_t>(plan_[static_cast<std::size_t>(c)])];
  }
  void make_row(const Level<Block>& fine, Index c, Level<Block>& coarse) const;
  void make_rows(const Level<Scalar>& fine, const std::array<Index, kQuad>& c,
                 Level<Scalar>& coarse) const;

  AlikeRows p_, transposed_;
  Pattern coarse_;
  std::vector<std::int32_t> start_;  // of each fine row's places if they are in a row, or −1
  std::vector<Plan> plans_;
  std::vector<std::int32_t> plan_;  // of each coarse row
};

}  // namespace multigrid
