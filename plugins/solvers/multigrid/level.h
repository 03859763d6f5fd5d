/// One level of nodes: the matrix there, products with it, and damped Jacobi steps.
#pragma once

#include <cstdint>
#include <vector>

#include <deform/parallel.h>
#include <deform/types.h>

#include "blocks.h"

namespace multigrid {

using deform::Index;

/// Rows that one task takes.
inline constexpr Index kRows = 256;

/// Full rows, columns ascending.
struct Pattern {
  Index nodes = 0;
  std::vector<std::int32_t> begin{0};  ///< (N + 1)
  std::vector<std::int32_t> column;

  /// Where (a, b) is kept, or −1.
  [[nodiscard]] std::int32_t place(Index a, Index b) const;
};

/// Components of a node that stay 0: their factors are 0, those of the others 1.
struct Mask {
  std::int32_t node = 0;
  Lanes factor;
};

template <class Entry>
struct Level {
  Pattern pattern;
  std::vector<float> value;    ///< Entry::kSize numbers a place, and room for one read beyond
  std::vector<float> inverse;  ///< of the diagonal, likewise
  std::vector<std::int32_t> diagonal;  ///< places
  std::vector<Mask> held;              ///< ascending
  LaneVector f, x, r;                  ///< right-hand side, correction, residual

  /// Makes room for the matrix of a pattern. `masks`: nodes with held components, ascending.
  void prepare(Pattern p, std::vector<Mask> masks);
  /// Takes rows and columns of held components out of the matrix, and inverts its diagonal.
  void finish();

  [[nodiscard]] Lanes row_times(Index a, const LaneVector& y) const {
    const std::int32_t end = pattern.begin[static_cast<std::size_t>(a) + 1];
    std::int32_t p = pattern.begin[static_cast<std::size_t>(a)];
    const float* v = value.data() + static_cast<std::size_t>(p) * Entry::kSize;
    const std::int32_t* column = pattern.column.data();
    Lanes even, odd;  // two chains of sums, so that one does not wait for the other
    for (; p + 1 < end; p += 2, v += 2 * Entry::kSize) {
      even += Entry::apply(v, y[static_cast<std::size_t>(column[p])]);
      odd += Entry::apply(v + Entry::kSize, y[static_cast<std::size_t>(column[p + 1])]);
    }
    if (p < end) even += Entry::apply(v, y[static_cast<std::size_t>(column[p])]);
    return even + odd;
  }
  [[nodiscard]] Lanes smoothed(Index a, const Lanes& residual) const {
    return damping_ *
           Entry::apply(inverse.data() + static_cast<std::size_t>(a) * Entry::kSize, residual);
  }
  void mask(LaneVector& y) const {
    for (const Mask& m : held) {
      Lanes& lanes = y[static_cast<std::size_t>(m.node)];
      lanes = m.factor * lanes;
    }
  }

  /// Chooses ω for steps that smooth, from an estimate of the largest eigenvalue of D⁻¹A.
  void choose_damping();

  /// x = ω D⁻¹ f.
  void start();
  /// r = f − A x.
  void find_residual();
  /// x += ω D⁻¹ (f − A x).
  void smooth();

 private:
  [[nodiscard]] double product(const LaneVector& a, const LaneVector& b);

  struct Cut {
    std::int32_t place = 0;
    Lanes row, column;
  };
  std::vector<Cut> cuts_;  // blocks with held components
  LaneVector next_;
  float damping_ = 0.65F;  // ω: right for membranes, whose largest eigenvalue is about 2
  std::vector<double> parts_;
};

}  // namespace multigrid
