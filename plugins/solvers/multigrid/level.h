/// One level of nodes: the matrix there, products with it, and damped Jacobi steps.
#pragma once

#include <concepts>
#include <cstdint>
#include <numeric>
#include <vector>

#include <deform/parallel.h>
#include <deform/types.h>

#include "blocks.h"

namespace multigrid {

/// Nodes, and quads of them, that one task takes.
inline constexpr Index kRows = 256, kQuads = kRows / kQuad;

/// Components of a node that stay 0: their factors are 0, those of the others 1.
struct Mask {
  std::int32_t node = 0;
  Lanes factor;
};

/// Sums over blocks of quads, taken in an order that does not depend on threads.
class Sums {
 public:
  /// body(first, size): the part of some quads.
  template <class Body>
  double operator()(Index quads, const Body& body) {
    parts_.resize(static_cast<std::size_t>((quads + kQuads - 1) / kQuads));
    deform::parallel_blocks(quads, kQuads, [&](Index first, Index size) {
      parts_[static_cast<std::size_t>(first / kQuads)] = body(first, size);
    });
    return std::accumulate(parts_.begin(), parts_.end(), 0.0);
  }

 private:
  std::vector<double> parts_;
};

template <class Entry>
struct Level {
  Pattern pattern;
  Quads quads;
  std::vector<float> value;            ///< Entry::kSize numbers a place
  std::vector<float> inverse;          ///< of the diagonal: node a has place a
  std::vector<std::int32_t> diagonal;  ///< places
  std::vector<Mask> held;              ///< ascending
  LaneVector f, x, r;                  ///< right-hand side, correction, residual

  /// Makes room for the matrix of a pattern. `masks`: nodes with held components, ascending.
  void prepare(Pattern p, std::vector<Mask> masks);
  /// Where (a, b), which the pattern has, is kept.
  [[nodiscard]] std::int32_t place(Index a, Index b) const;
  /// Takes rows and columns of held components out of the matrix, and inverts its diagonal.
  void finish();

  /// out = A y on some quads.
  void multiply(const LaneVector& y, Index first, Index size, LaneVector& out) const {
    Entry::multiply(quads.view(), value.data(), y.data(), first, first + size, out.data());
  }
  /// ω D⁻¹ of a residual at one node.
  [[nodiscard]] Lanes smoothed(Index a, const Lanes& residual) const {
    return damping_ *
           Entry::apply(inverse.data() + Entry::start(static_cast<std::int32_t>(a)), residual);
  }
  void mask(LaneVector& y) const {
    for (const Mask& m : held) y.set(m.node, m.factor * y.node(m.node));
  }

  /// Chooses ω for steps that smooth, from an estimate of the largest eigenvalue of D⁻¹A …
  void choose_damping();
  /// … or from its bound by sums of rows, which takes one pass. Signs that alternate with the
  /// distance, as those of differences do, make it sharp; coarser matrices have others.
  void choose_damping_by_rows() requires std::same_as<Entry, Scalar>;

  /// x = ω D⁻¹ f.
  void start();
  /// r = f − A x.
  void find_residual();
  /// x += ω D⁻¹ (f − A x).
  void smooth();
  /// The same, and f·x of what becomes of x.
  [[nodiscard]] double smooth_and_multiply();
  [[nodiscard]] double product(const LaneVector& a, const LaneVector& b);

 private:
  void smooth_some(Index first, Index size);

  struct Cut {
    std::int32_t place = 0;
    Lanes row, column;
  };
  std::vector<Cut> cuts_;  // blocks with held components
  LaneVector next_;
  std::vector<float> largest_;  // bounds of quads
  float damping_ = 0.65F;       // ω: right for membranes, whose largest eigenvalue is about 2
  Sums sums_;
};

}  // namespace multigrid
