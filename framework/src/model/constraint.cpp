#include "deform/model/constraint.h"

namespace deform {

Reduction::Reduction(Index nodes) : nodes_(nodes) {
  for (auto& component : prescribed_) component.assign(static_cast<std::size_t>(nodes), 0);
}

void Reduction::prescribe(Index node, int component) {
  prescribed_.at(static_cast<std::size_t>(component)).at(static_cast<std::size_t>(node)) = 1;
}

std::vector<Index> Reduction::free_nodes(int component) const {
  std::vector<Index> free;
  for (Index node = 0; node < nodes_; ++node) {
    if (!prescribed(node, component)) free.push_back(node);
  }
  return free;
}

Constraint::~Constraint() = default;

}  // namespace deform
