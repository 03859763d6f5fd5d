/// Coarser matrices by Galerkin's product PᵀAP.
#pragma once

#include <vector>

#include <deform/surface/prolongation.h>

#include "level.h"

namespace multigrid {

/// PᵀAP for one P and one pattern of A: where each product goes is found once. Coarse rows are made
/// in strips, each from the rows of AP that it needs, kept in a buffer of its own; two strips may
/// make the same row of AP.
class Galerkin {
 public:
  Galerkin(const Pattern& fine, const deform::Prolongation& p);

  [[nodiscard]] const Pattern& coarse() const { return coarse_; }
  /// The values of PᵀAP; `fine` without its held rows and columns, so that P needs to know of none.
  template <class Entry>
  void multiply(const Level<Entry>& fine, Level<Entry>& coarse) const;
  /// f of the coarse level from the residual r: Pᵀ r.
  void restrict_to(const LaneVector& r, LaneVector& f) const;
  /// x_a + (P x)_a.
  [[nodiscard]] Lanes prolonged(Index a, const LaneVector& coarse) const {
    Lanes sum;
    for (auto q = begin_[static_cast<std::size_t>(a)]; q < begin_[static_cast<std::size_t>(a) + 1];
         ++q)
      sum += weight_[static_cast<std::size_t>(q)] * coarse.node(node_[static_cast<std::size_t>(q)]);
    return sum;
  }
  /// The coarse node that a fine one is, or −1.
  [[nodiscard]] std::int32_t same(Index fine) const;

 private:
  struct Strip {
    Index first = 0, size = 0;       // coarse rows
    std::vector<std::int32_t> rows;  // of AP, ascending
  };
  void transpose(Index coarse);
  void make_product(const Pattern& fine);
  void make_coarse();
  void make_strips();
  template <class Entry>
  void make_row(const Level<Entry>& fine, std::size_t row, Sum<Entry>* blocks) const;

  std::vector<std::int32_t> begin_, node_;  // P by rows
  std::vector<float> weight_;
  std::vector<std::int32_t> t_begin_, t_node_;  // Pᵀ by rows …
  std::vector<float> t_weight_;
  std::vector<std::int32_t> product_begin_, product_column_;  // pattern of AP
  std::vector<std::size_t> slot_begin_;                       // of a fine row …
  std::vector<std::uint16_t> slot_;  // … places in its row of AP, of each entry of A and of P
  Pattern coarse_;
  std::vector<std::size_t> coarse_slot_begin_;  // of a coarse row …
  std::vector<std::uint16_t> coarse_slot_;      // … places in it, of each entry of Pᵀ and of AP
  std::vector<std::int32_t> local_;             // place among a strip's rows, of each entry of Pᵀ
  std::vector<Strip> strips_;
};

}  // namespace multigrid
