/// The nodes of a grid's sides and their derivatives, on functions whose derivatives are known.
#include <map>

#include <fmt/format.h>

#include "model/support/simulate.h"

namespace deform {
namespace {

Simulation grid(const std::string& more) {
  return test::simulation_from_text(fmt::format(
      R"({{"surface": {{"plugin": "grid", "nodes": [6, 5], "size": [1.5, 0.8]{}}},
        "integrator": {{"plugin": "semi_implicit", "step": 0.1}}, "duration": 0.1}})",
      more));
}

double derivative(const Surface& surface, const std::vector<EdgeNode::Entry>& row,
                  const std::function<double(double, double)>& f) {
  double sum = 0;
  for (const auto& [node, coefficient] : row)
    sum += coefficient * f(surface.parameters()(node, 0), surface.parameters()(node, 1));
  return sum;
}

/// Unit vectors inwards and along, counter-clockwise.
const std::map<std::string, std::pair<Vec2, Vec2>> kDirections{{"bottom", {{0, 1}, {1, 0}}},
                                                               {"right", {{-1, 0}, {0, 1}}},
                                                               {"top", {{0, -1}, {-1, 0}}},
                                                               {"left", {{1, 0}, {0, -1}}}};

TEST(GridEdges, DifferentiateQuadraticsExactly) {
  const auto linear = [](double x, double y) { return 0.3 + 2 * x - 5 * y; };
  const auto quadratic = [](double x, double y) { return x * x - 3 * x * y + 2 * y * y + x - y; };
  for (const std::string more :
       {R"(, "differences": "symmetric")", R"(, "differences": "central")",
        R"(, "differences": "forward", "border": "paper", "weights": "equal")"}) {
    Simulation s = grid(more);
    const Surface& surface = s.system().surface();
    ASSERT_EQ(surface.boundary_names().size(), 4U);
    for (const std::string& name : surface.boundary_names()) {
      const auto& [inwards, along] = kDirections.at(name);
      const std::vector<EdgeNode> edge = surface.edge(name);
      const std::vector<Index> boundary = surface.boundary(name);
      ASSERT_EQ(edge.size(), boundary.size());
      double length = 0;
      for (std::size_t k = 0; k < edge.size(); ++k) {
        EXPECT_EQ(edge[k].node, boundary[k]);
        length += edge[k].length;
        const Vec2 a = surface.parameters().row(edge[k].node);
        const Vec2 slope(2 * a.x() - 3 * a.y() + 1, -3 * a.x() + 4 * a.y() - 1);
        EXPECT_NEAR(derivative(surface, edge[k].inwards, linear), Vec2(2, -5).dot(inwards), 1e-13);
        EXPECT_NEAR(derivative(surface, edge[k].along, linear), Vec2(2, -5).dot(along), 1e-13);
        EXPECT_NEAR(derivative(surface, edge[k].inwards, quadratic), slope.dot(inwards), 1e-13);
        EXPECT_NEAR(derivative(surface, edge[k].along, quadratic), slope.dot(along), 1e-13);
      }
      EXPECT_NEAR(length, std::abs(along.x()) * 1.5 + std::abs(along.y()) * 0.8, 1e-15);
      EXPECT_DOUBLE_EQ(edge.front().length, edge[1].length / 2);
      EXPECT_DOUBLE_EQ(edge.back().length, edge[1].length / 2);
    }
    EXPECT_TRUE(surface.edge("all").empty());
    EXPECT_TRUE(surface.edge("lid").empty());
  }
}

/// Along a joined direction the ends of a side are as its middle, and the joined sides are none.
TEST(GridEdges, OfATubeCloseUp) {
  Simulation s = grid(
      R"(, "periodic": [true, false], "rest": {"plugin": "arc", "radius": 0.238732414637843})");
  const Surface& surface = s.system().surface();
  EXPECT_TRUE(surface.edge("left").empty());
  const std::vector<EdgeNode> bottom = surface.edge("bottom");
  ASSERT_EQ(bottom.size(), 6U);
  const double h = 1.5 / 6;
  for (std::size_t k = 0; k < bottom.size(); ++k) {
    EXPECT_DOUBLE_EQ(bottom[k].length, h);
    std::map<Index, double> along;
    for (const auto& [node, coefficient] : bottom[k].along) along[node] = coefficient;
    const auto node = static_cast<Index>(k);
    EXPECT_EQ(along, (std::map<Index, double>{{(node + 1) % 6, 1 / (2 * h)},
                                              {(node + 5) % 6, -1 / (2 * h)}}));
  }
}

}  // namespace
}  // namespace deform
