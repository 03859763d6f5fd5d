#include "solve/matrix/unknowns.h"

#include <algorithm>

namespace deform {
namespace {

std::size_t place(const Freedom& f) { return static_cast<std::size_t>(3 * f.node + f.component); }

}  // namespace

Unknowns::Unknowns(const ReductionMap& map, const std::vector<Freedom>& held) : map_(&map) {
  const Index nodes = map.reduction().nodes();
  number_.assign(static_cast<std::size_t>(3 * nodes), -1);
  for (Index a = 0; a < nodes; ++a)
    for (int c = 0; c < 3; ++c) {
      const Freedom freedom{a, c};
      if (!map.reduction().free(a, c) || std::ranges::find(held, freedom) != held.end()) continue;
      number_[place(freedom)] = size();
      freedom_of_.push_back(freedom);
    }
}

std::vector<std::uint8_t> Unknowns::held() const {
  std::vector<std::uint8_t> held(number_.size() / 3, 0);
  for (std::size_t i = 0; i < number_.size(); ++i)
    if (number_[i] < 0) held[i / 3] |= static_cast<std::uint8_t>(1U << (i % 3));
  return held;
}

std::vector<ReducedMatrix::Part> Unknowns::row(const Freedom& freedom) const {
  std::vector<ReducedMatrix::Part> row;
  for (const Tie::Part& part : map_->row(freedom))
    if (const Index q = number_[place(part.of)]; q >= 0) row.push_back({q, part.coefficient});
  return row;
}

Eigen::VectorXd Unknowns::gathered(const NodeVectors& field) const {
  Eigen::VectorXd values(size());
  for (Index q = 0; q < size(); ++q) values[q] = field((*this)[q].node, (*this)[q].component);
  return values;
}

Eigen::VectorXd Unknowns::reduced(NodeVectors f) const {
  map_->transpose(f);
  return gathered(f);
}

NodeVectors Unknowns::expanded(const Eigen::VectorXd& y) const {
  NodeVectors x = NodeVectors::Zero(map_->reduction().nodes(), 3);
  for (Index q = 0; q < size(); ++q) x((*this)[q].node, (*this)[q].component) = y[q];
  map_->complete_changes(x);
  return x;
}

}  // namespace deform
