/// Difference operators along one direction of a grid; products of two lines' make those of the
/// surface.
#pragma once

#include <utility>
#include <vector>

#include <deform/types.h>

namespace grid {

using deform::Index;

enum class Scheme { forward, central };
enum class Border {
  paper,      ///< a difference that would reach over the border does not exist (a zero row)
  one_sided,  ///< it is replaced by one that does not reach over
};

/// One row: (index along the line, coefficient), ascending; empty where the difference does not
/// exist.
using Row = std::vector<std::pair<Index, double>>;

/// The operators of a line of n nodes at a spacing h.
struct Line {
  std::vector<Row> d;      ///< D_i^+, or the central difference [1/h]
  std::vector<Row> dd;     ///< D_ii [1/h²]
  std::vector<Row> minus;  ///< D_i^-, or the central difference; for fields of samples
  std::vector<Row> frame;  ///< central, one-sided at the ends: tangents where d does not exist
};

/// n >= 3. Periodic lines wrap around and have no border.
[[nodiscard]] Line make_line(Index n, double h, bool periodic, Scheme scheme, Border border);

}  // namespace grid
