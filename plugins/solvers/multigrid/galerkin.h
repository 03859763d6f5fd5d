/// Coarser matrices by Galerkin's product PᵀAP, and vectors between the levels.
#pragma once

#include <compare>
#include <cstdint>
#include <vector>

#include <deform/surface/prolongation.h>

#include "alike_rows.h"
#include "field.h"
#include "galerkin_kernels.h"
#include "runs.h"
#include "strips.h"

namespace multigrid {

/// For one P and one pattern of A. Which entries of A make which of PᵀAP is found once, and shared
/// by the coarse rows that are alike; those that follow each other are made together.
class Galerkin {
 public:
  Galerkin(const Pattern& fine, const deform::Prolongation& p);

  [[nodiscard]] const Pattern& coarse() const { return coarse_; }
  /// Once both are there: where entries of so many numbers lie. Forgets what only this needs,
  /// `coarse` and `same` included.
  void bind(const Strips& fine, const Strips& coarse, Index numbers);

  /// The values of PᵀAP. Held rows and columns of `fine` are 0, so that P needs to know of none.
  template <class Entry>
  void multiply(const std::vector<float>& fine, std::vector<float>& coarse) const;
  /// f = Pᵀ r.
  void restrict_to(const Field<float>& r, Field<float>& f) const;
  /// P.
  [[nodiscard]] const Runs& interpolation() const { return up_; }
  /// The coarse node at a fine one, or −1.
  [[nodiscard]] std::int32_t same(Index fine) const;

 private:
  /// An entry of A, from the first fine row that a coarse one is made of.
  struct Source {
    std::int32_t row = 0, distance = 0;
    auto operator<=>(const Source&) const = default;
  };
  struct Plan {
    std::vector<Source> sources;         // ascending
    std::vector<std::int32_t> distance;  // of entries: coarse column less row
    std::vector<Term> terms;
    std::vector<std::uint32_t> end;  // as CoarseRows wants it
    auto operator<=>(const Plan&) const = default;
  };
  class Planner;
  /// Coarse rows made together, each `step` fine rows after the one before.
  struct Group {
    std::int32_t size, step;
    std::size_t plan, place;  // place: of the first row's sources, then entries, in places_
  };

  [[nodiscard]] bool lies_in_strips(const Strips& fine, std::int32_t first,
                                    std::int32_t last) const;
  [[nodiscard]] std::int32_t group_end(const Strips& fine, const Strips& coarse,
                                       std::int32_t first) const;

  AlikeRows p_, transposed_;
  Runs up_, down_;
  Pattern coarse_;
  std::vector<Plan> plans_;
  std::vector<std::int32_t> plan_;   // of each coarse row …
  std::vector<std::int32_t> begin_;  // … and its first fine row
  std::vector<Group> groups_;
  std::vector<Place> places_;
};

}  // namespace multigrid
