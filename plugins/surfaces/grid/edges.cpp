#include "edges.h"

#include "differences.h"
#include "rest_areas.h"

namespace grid {

using deform::EdgeNode;

std::vector<EdgeNode> edge(const Lattice& lattice, const deform::NodeVectors& rest,
                           const std::string& name) {
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

  const std::vector<Index> nodes = side(lattice, name);
  if (nodes.empty()) return {};
  std::vector<double> lengths;
  for (std::size_t k = 0; k < nodes.size(); ++k)
    lengths.push_back(lattice.h[along] * lattice.share(along, static_cast<Index>(k)));
  const std::vector<double> of_rest =
      rest_lengths(nodes, lattice.h[along], lattice.periodic[along], lengths, rest);

  std::vector<EdgeNode> result;
  for (const Index node : nodes) {
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
    const auto k = static_cast<std::size_t>(at[along]);
    result.push_back({node, lengths[k], of_rest[k], entries(row_across, across, inwards),
                      entries(line_along.d[k], along, forwards)});
  }
  return result;
}

}  // namespace grid
