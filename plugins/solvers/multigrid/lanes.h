/// Vectors of nodes, four lanes each: three components and a fourth that is 0.
#pragma once

#include <cstddef>
#include <cstring>
#include <vector>

#include "kernels.h"

namespace multigrid {

/// The lanes of a node in single precision.
struct Lanes {
  using Register [[gnu::vector_size(16)]] = float;
  Register v{};

  static Lanes load(const float* from) {
    Lanes x;
    std::memcpy(&x.v, from, sizeof x.v);
    return x;
  }
  void store(float* to) const { std::memcpy(to, &v, sizeof v); }
  float operator[](int c) const { return v[c]; }
  void set(int c, float value) { v[c] = value; }

  Lanes& operator+=(const Lanes& o) {
    v += o.v;
    return *this;
  }
  friend Lanes operator+(Lanes a, const Lanes& b) { return a += b; }
  friend Lanes operator*(const Lanes& a, const Lanes& b) { return {a.v * b.v}; }
  friend Lanes magnitude(const Lanes& a) { return {a.v < 0 ? -a.v : a.v}; }
  friend Lanes operator*(float s, const Lanes& a) { return {s * a.v}; }
};

/// Numbers of nodes, up to a whole quad.
template <class Number>
class NodeLanes {
 public:
  void assign(Index nodes) { values_.assign(4 * padded(nodes), 0); }
  void set_zero(Index quads) { values_.assign(static_cast<std::size_t>(16 * quads), 0); }
  /// What it holds then is of no use.
  void resize(Index quads) { values_.resize(static_cast<std::size_t>(16 * quads)); }

  [[nodiscard]] Index quads() const { return static_cast<Index>(values_.size() / 16); }
  [[nodiscard]] Number* data() { return values_.data(); }
  [[nodiscard]] const Number* data() const { return values_.data(); }
  [[nodiscard]] Number& operator()(Index a, Index c) {
    return values_[static_cast<std::size_t>(4 * a + c)];
  }
  [[nodiscard]] Number operator()(Index a, Index c) const {
    return values_[static_cast<std::size_t>(4 * a + c)];
  }
  [[nodiscard]] Lanes node(Index a) const { return Lanes::load(values_.data() + 4 * a); }
  void set(Index a, const Lanes& lanes) { lanes.store(values_.data() + 4 * a); }
  void swap(NodeLanes& other) { values_.swap(other.values_); }

 private:
  std::vector<Number> values_;
};

using LaneVector = NodeLanes<float>;

}  // namespace multigrid
