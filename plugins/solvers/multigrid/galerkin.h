/// Coarser matrices by Galerkin's product PᵀAP.
#pragma once

#include <array>
#include <compare>
#include <vector>

#include <deform/surface/prolongation.h>

#include "alike_rows.h"
#include "level.h"

namespace multigrid {

/// PᵀAP for one P and one pattern of A. Coarse rows are made by fours: their rows of T = PᵀA, then
/// those times P. Where the products go is found once, and shared by the rows that are alike.
class Galerkin {
 public:
  Galerkin(const Pattern& fine, const Quads& quads, const deform::Prolongation& p);

  [[nodiscard]] const Pattern& coarse() const { return coarse_; }
  /// The values of PᵀAP; `fine` without its held rows and columns, so that P needs to know of none.
  template <class Entry>
  void multiply(const Level<Entry>& fine, Level<Entry>& coarse) const;
  /// f of the coarse level from the residual r: Pᵀ r.
  void restrict_to(const LaneVector& r, LaneVector& f) const;
  /// (P x)_a.
  [[nodiscard]] Lanes prolonged(Index a, const LaneVector& coarse) const {
    return p_.product(a, coarse);
  }
  /// The coarse node at a fine one, or −1.
  [[nodiscard]] std::int32_t same(Index fine) const;

 private:
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

  [[nodiscard]] const Plan& plan_of(Index c) const {
    return plans_[static_cast<std::size_t>(plan_[static_cast<std::size_t>(c)])];
  }
  template <class Entry>
  void make_rows(const Level<Entry>& fine, const std::array<Index, kQuad>& c,
                 Level<Entry>& coarse) const;

  AlikeRows p_, transposed_;
  Pattern coarse_;
  std::vector<std::int32_t> start_;  // of each fine row's places if they are in a row, or −1
  std::vector<Plan> plans_;
  std::vector<std::int32_t> plan_;  // of each coarse row
};

}  // namespace multigrid
