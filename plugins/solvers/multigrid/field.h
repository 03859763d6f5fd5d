/// Vectors of nodes: three components, each in an array of its own.
#pragma once

#include <cstddef>
#include <vector>

#include <deform/types.h>

namespace multigrid {

using deform::Index;

/// Three components, as kernels take them: each in an array, `stride` apart.
template <class Number>
struct Components {
  Number* data;
  Index stride;
};

/// (3 × stride): component c of node a at data(c)[a]. What lies behind the nodes is 0 and stays so:
/// kernels read whole vectors of the processor, and rows of a strip the columns of their fellows.
template <class Number>
class Field {
 public:
  void assign(Index nodes, Index stride) {
    nodes_ = nodes, stride_ = stride;
    values_.assign(static_cast<std::size_t>(3 * stride), 0);
  }
  void set_zero() { values_.assign(values_.size(), 0); }

  [[nodiscard]] Index nodes() const { return nodes_; }
  [[nodiscard]] Index stride() const { return stride_; }
  [[nodiscard]] Number* data(Index c) { return values_.data() + c * stride_; }
  [[nodiscard]] const Number* data(Index c) const { return values_.data() + c * stride_; }
  [[nodiscard]] Components<const Number> read() const { return {values_.data(), stride_}; }
  [[nodiscard]] Components<Number> write() { return {values_.data(), stride_}; }
  [[nodiscard]] Number& operator()(Index a, Index c) { return data(c)[a]; }
  [[nodiscard]] Number operator()(Index a, Index c) const { return data(c)[a]; }

 private:
  Index nodes_ = 0, stride_ = 0;
  std::vector<Number> values_;
};

}  // namespace multigrid
