#include "coarsening.h"

#include <algorithm>

namespace mesh {
namespace {

using namespace deform;

/// So few nodes are not coarsened; each level has at most this part of the nodes before.
constexpr std::size_t kFew = 40;
constexpr double kMost = 0.6;

/// Of each node, those it has an edge with, ascending.
using Graph = std::vector<std::vector<std::int32_t>>;

void make_unique(std::vector<std::int32_t>& nodes) {
  std::ranges::sort(nodes);
  nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
}

Graph graph_of(const Triangles& t) {
  Graph graph(static_cast<std::size_t>(t.nodes()));
  for (const Triangle& corners : t.all)
    for (std::size_t k = 0; k < 3; ++k)
      for (const std::size_t j : {(k + 1) % 3, (k + 2) % 3})
        graph[static_cast<std::size_t>(corners[k])].push_back(corners[j]);
  for (auto& beside : graph) make_unique(beside);
  return graph;
}

/// Numbers of the coarse nodes, −1 of others.
std::vector<std::int32_t> choose(const Graph& graph, std::int32_t& count) {
  std::vector<std::int32_t> number(graph.size(), -1);
  std::vector<bool> is_beside(graph.size(), false);
  count = 0;
  for (std::size_t a = 0; a < graph.size(); ++a) {
    if (is_beside[a]) continue;
    number[a] = count++;
    for (const std::int32_t b : graph[a]) is_beside[static_cast<std::size_t>(b)] = true;
  }
  return number;
}

Prolongation prolongation(const Graph& graph, const NodeVectors& r,
                          const std::vector<std::int32_t>& number, std::int32_t count) {
  Prolongation p;
  p.coarse = count;
  p.begin.assign(1, 0);
  for (std::size_t a = 0; a < graph.size(); ++a) {
    double sum = 0;
    const std::size_t begin = p.node.size();
    const auto add = [&](std::int32_t coarse, double weight) {
      p.node.push_back(coarse);
      p.weight.push_back(weight);
      sum += weight;
    };
    if (number[a] >= 0) {
      add(number[a], 1);
    } else {
      for (const std::int32_t b : graph[a])
        if (const std::int32_t coarse = number[static_cast<std::size_t>(b)]; coarse >= 0)
          add(coarse, 1 / (r.row(static_cast<Index>(a)) - r.row(b)).norm());
    }
    for (std::size_t k = begin; k < p.weight.size(); ++k) p.weight[k] /= sum;
    p.begin.push_back(static_cast<std::int32_t>(p.node.size()));
  }
  return p;
}

/// Between coarse nodes that interpolate one node.
Graph coarser(const Prolongation& p) {
  Graph graph(static_cast<std::size_t>(p.coarse));
  for (std::size_t a = 0; a + 1 < p.begin.size(); ++a)
    for (auto i = static_cast<std::size_t>(p.begin[a]);
         i < static_cast<std::size_t>(p.begin[a + 1]); ++i)
      for (auto j = static_cast<std::size_t>(p.begin[a]);
           j < static_cast<std::size_t>(p.begin[a + 1]); ++j)
        if (i != j) graph[static_cast<std::size_t>(p.node[i])].push_back(p.node[j]);
  for (auto& beside : graph) make_unique(beside);
  return graph;
}

}  // namespace

std::vector<Prolongation> coarsening(const Triangles& t) {
  std::vector<Prolongation> levels;
  Graph graph = graph_of(t);
  NodeVectors r = t.positions;
  while (graph.size() > kFew) {
    std::int32_t count = 0;
    const std::vector<std::int32_t> number = choose(graph, count);
    if (count > kMost * static_cast<double>(graph.size())) break;
    levels.push_back(prolongation(graph, r, number, count));
    NodeVectors kept(count, 3);
    for (std::size_t a = 0; a < number.size(); ++a)
      if (number[a] >= 0) kept.row(number[a]) = r.row(static_cast<Index>(a));
    r = std::move(kept);
    graph = coarser(levels.back());
  }
  return levels;
}

}  // namespace mesh
