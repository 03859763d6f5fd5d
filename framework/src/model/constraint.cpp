#include "deform/model/constraint.h"

#include <string>

#include "deform/error.h"

namespace deform {

Reduction::Reduction(Index nodes) : nodes_(nodes) {
  for (auto& component : prescribed_) component.assign(static_cast<std::size_t>(nodes), 0);
}

void Reduction::prescribe(Index node, int component) {
  if (node < 0 || node >= nodes_)
    throw Error(ExitCode::plugin_failed, "it prescribes node " + std::to_string(node) +
                                             ", expected 0 to " + std::to_string(nodes_ - 1));
  if (component < 0 || component > 2)
    throw Error(ExitCode::plugin_failed, "it prescribes component " + std::to_string(component) +
                                             ", expected 0, 1 or 2 for x, y or z");
  prescribed_[static_cast<std::size_t>(component)][static_cast<std::size_t>(node)] = 1;
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
