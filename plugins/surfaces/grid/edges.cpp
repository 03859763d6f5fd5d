#include "edges.h"

#include "differences.h"

namespace grid {

using deform::EdgeNode;

std::vector<EdgeNode> edge(const Lattice& lattice, const std::string& name) {
  const bool is_vertical = name == "left" || name == "right";
  const std::size_t across = is_vertical ? 0 : 1, along = 1 - across;
  const Line line_across = make_line(lattice.n[across], lattice.h[across], lattice.periodic[across],
                                     Scheme::central, Border::one_sided);
  const Line line_along = make_line(lattice.n[along], lattice.h[along], lattice.periodic[along],
                                    Scheme::central, Border::one_sided);
  // Counter-clockwise: with a1 below, with a2 at the right, against them above and at the left.
  const bool is_last = name == "right" || name == "top";
  const double inwards = is_last ? -1 : 1;
  const double forwards = name == "bottom" || name == "right" ? 1 : -1;
  const Row& row_across = is_last ? line_across.d.back() : line_across.d.front();

  std::vector<EdgeNode> result;
  for (const Index node : side(lattice, name)) {
    const std::array<Index, 2> at{node % lattice.n[0], node / lattice.n[0]};
    const auto entries = [&](const Row& row, std::size_t direction, double sign) {
      std::vector<EdgeNode::Entry> list;
      for (const auto& [line, coefficient] : row) {
        std::array<Index, 2> place = at;
        place[direction] = line;
        list.push_back({lattice.node(place[0], place[1]), sign * coefficient});
      }
      return list;
    };
    const Index k = at[along];
    result.push_back({node, lattice.h[along] * lattice.share(along, k),
                      entries(row_across, across, inwards),
                      entries(line_along.d[static_cast<std::size_t>(k)], along, forwards)});
  }
  return result;
}

}  // namespace grid
