/// One level of nodes: the matrix there, products with it, and damped Jacobi steps.
#pragma once

#include <concepts>
#include <cstdint>
#include <numeric>
#include <vector>

#include <deform/parallel.h>

#include "entries.h"
#include "field.h"
#include "product.h"
#include "strips.h"

namespace multigrid {

/// Components of a node that stay 0, as bits.
struct Held {
  std::int32_t node = 0;
  std::uint8_t components = 0;
};

/// Sums of what each of some tasks has, in their order, which does not depend on threads.
class Sums {
 public:
  void resize(std::size_t tasks) { parts_.resize(tasks); }
  double& operator[](std::size_t task) { return parts_[task]; }
  [[nodiscard]] double total() const { return std::accumulate(parts_.begin(), parts_.end(), 0.0); }

 private:
  std::vector<double> parts_;
};

template <class Entry>
class Level {
 public:
  Strips strips;
  std::vector<float> value;  ///< of the strips
  std::vector<Held> held;    ///< ascending
  Field<float> f, x, r;      ///< right-hand side, correction, residual

  /// Makes room for the matrix of a pattern. `nodes_held`: ascending.
  void prepare(const Pattern& pattern, std::vector<Held> nodes_held);
  [[nodiscard]] Index nodes() const { return f.nodes(); }
  /// A field of the level's nodes, 0.
  template <class Number>
  void assign(Field<Number>& field) const {
    field.assign(nodes(), f.stride());
  }
  /// Takes rows and columns of held components out of the matrix, and inverts its diagonal.
  void finish();

  /// out = A y; returns y·A y.
  [[nodiscard]] double multiply(const Field<float>& y, Field<float>& out);
  [[nodiscard]] double product(const Field<float>& a, const Field<float>& b);
  void mask(Field<float>& y) const;

  /// Chooses ω for steps that smooth, from an estimate of the largest eigenvalue of D⁻¹A …
  void choose_damping();
  /// … or from its bound by sums of rows, which takes one pass. Signs that alternate with the
  /// distance, as those of differences do, make it sharp; coarser matrices have others.
  void choose_damping_by_rows() requires std::same_as<Entry, Scalar>;

  /// x = ω D⁻¹ f for nodes first … first+size−1.
  void start(Index first, Index size);
  void start() { start(0, nodes()); }
  /// r = f − A x.
  void find_residual();
  /// x += ω D⁻¹ (f − A x).
  void smooth();
  /// The same, and f·x of what becomes of x.
  [[nodiscard]] double smooth_and_multiply();

 private:
  [[nodiscard]] Inverse inverse() const { return {inverse_.data(), nodes()}; }
  void find_cuts();
  [[nodiscard]] double largest_eigenvalue(Index first, Index end);
  void add_correction(Index first, Index size);

  std::vector<float> inverse_;      // of the diagonal
  std::vector<std::int64_t> cuts_;  // numbers of held components in the matrix
  Product<float> product_;
  float damping_ = 0.65F;  // ω: right for membranes, whose largest eigenvalue is about 2
  Sums sums_;
};

/// Σ over components of a·b for some nodes.
template <class Number>
[[nodiscard]] double dot(const Field<Number>& a, const Field<Number>& b, Index first, Index size) {
  double sum = 0;
  for (Index c = 0; c < 3; ++c) sum += dot(size, a.data(c) + first, b.data(c) + first);
  return sum;
}

}  // namespace multigrid
