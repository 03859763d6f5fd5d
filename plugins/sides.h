/// Open sides of a surface, for constraints and loads along them.
#pragma once

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include <deform/error.h>
#include <deform/surface/surface.h>

namespace deform {

/// An open side with its nodes and their derivatives.
struct Side {
  std::string name;
  std::vector<EdgeNode> nodes;
};

/// The sides that a selection names, each once; "all" are all that are open. Throws InputError for
/// a selection of other kinds than `boundary`, for unknown names, and for surfaces that do not know
/// what lies across their sides.
inline std::vector<Side> select_sides(const NodeSelection& where, const Setup& setup) {
  const Surface& surface = setup.surface();
  for (const NodeSelector& selector : where.selectors)
    if (selector.form != NodeSelector::Form::boundary)
      throw InputError({{where.pointer,
                         "takes sides only, as {\"boundary\": \"left\"}: other nodes have no "
                         "direction across a side"}});
  (void)setup.select(where);  // says which names are unknown
  std::vector<std::string> names;
  const auto add = [&](const std::string& name) {
    if (std::ranges::find(names, name) == names.end()) names.push_back(name);
  };
  for (const NodeSelector& selector : where.selectors)
    for (const std::string& name : selector.names) {
      if (name == "all")
        std::ranges::for_each(surface.boundary_names(), add);
      else
        add(name);
    }
  std::vector<Side> sides;
  for (const std::string& name : names) {
    Side side{name, surface.edge(name)};
    if (side.nodes.empty())
      throw InputError(
          {{where.pointer, "the surface gives no derivatives across its side '" + name + "'"}});
    sides.push_back(std::move(side));
  }
  return sides;
}

/// The length of the side that a node stands for [m]: of the rest surface, or in the parameters
/// where the scene's masses and loads go by these.
inline double length_of(const EdgeNode& edge, const Setup& setup) {
  const bool is_of_rest = setup.material().mass == AreaOf::rest && edge.rest_length > 0;
  return is_of_rest ? edge.rest_length : edge.length;
}

/// A derivative at an edge node: Σ c_k r_k.
template <class Positions>
Vec3 derivative(const std::vector<EdgeNode::Entry>& row, const Positions& r) {
  Vec3 sum = Vec3::Zero();
  for (const auto& [node, coefficient] : row) sum += coefficient * r(node);
  return sum;
}
inline Vec3 derivative(const std::vector<EdgeNode::Entry>& row, const NodeVectors& r) {
  return derivative(row, [&](Index node) { return Vec3(r.row(node)); });
}
inline Vec3 derivative(const std::vector<EdgeNode::Entry>& row, ConstVectors r) {
  return derivative(row, [&](Index node) { return r[node]; });
}

}  // namespace deform
