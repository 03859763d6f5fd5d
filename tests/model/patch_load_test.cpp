/// Loads on patches of the surface, which do not depend on the grid.
#include <algorithm>
#include <string>

#include "model/support/simulate.h"

namespace deform {
namespace {

using test::simulation_from_text;

std::string scene(int nodes, const std::string& where, const std::string& surface = "") {
  const std::string n = std::to_string(nodes);
  return R"({"surface": {"plugin": "grid", "nodes": [)" + n + ", " + n + R"(], "size": [1, 1])" +
         surface + R"(}, "forces": [{"plugin": "point_load", "force": [0, 0, 2], "where": )" +
         where + R"(}], "integrator": {"plugin": "symplectic_euler", "step": 1}, "duration": 1})";
}

struct Load {
  double total = 0;
  Vec2 centre = Vec2::Zero();
  Index nodes = 0;
};

Load load_of(Simulation s) {
  const NodeValues f = s.system().terms().external_force(s.state()).col(2);
  const Vec2 moment = s.system().surface().parameters().transpose() * f;
  return {f.sum(), moment / f.sum(), (f.array() != 0).count()};
}

const std::string kPatch = R"({"centre": [0.47, 0.52], "radius": 0.06})";

TEST(PatchLoad, HasTheSameForceAndPlaceOnEveryGrid) {
  for (const int nodes : {5, 11, 21, 31, 41}) {
    const Load load = load_of(simulation_from_text(scene(nodes, kPatch)));
    EXPECT_NEAR(load.total, 2, 1e-13) << nodes;
    EXPECT_LT((load.centre - Vec2(0.47, 0.52)).norm(), 1e-13) << nodes;
  }
}

/// What sticks out of the surface, and what two patches have in common, does not count (again).
TEST(PatchLoad, IsCutAtTheBorderAndUnited) {
  const Load cut = load_of(simulation_from_text(scene(21, R"({"box": [[0.9, 0.4], [1.3, 0.5]]})")));
  EXPECT_LT((cut.centre - Vec2(0.95, 0.45)).norm(), 1e-13);
  // An L of the areas 0.2 × 0.1 and 0.1 × 0.1, whose corner both boxes have.
  const Load united = load_of(simulation_from_text(
      scene(21, R"([{"box": [[0.2, 0.2], [0.4, 0.3]]}, {"box": [[0.2, 0.2], [0.3, 0.4]]}])")));
  EXPECT_LT((united.centre - (2 * Vec2(0.3, 0.25) + Vec2(0.25, 0.35)) / 3).norm(), 1e-13);
  EXPECT_NEAR(united.total, 2, 1e-13);
  const Load whole = load_of(simulation_from_text(scene(21, R"({"box": [[0, 0], [1, 1]]})")));
  EXPECT_EQ(whole.nodes, 441);
}

TEST(PatchLoad, GoesRoundJoinedSides) {
  const Load load = load_of(
      simulation_from_text(scene(16, R"({"centre": [0, 0.5], "radius": 0.1})",
                                 R"s(, "periodic": [true, false], "rest": {"plugin": "formula",
                 "x": "sin(2*pi*a1)", "z": "cos(2*pi*a1)"})s")));
  EXPECT_NEAR(load.total, 2, 1e-13);
  EXPECT_NEAR(load.centre.y(), 0.5, 1e-13);
  EXPECT_GT(load.nodes, 8);
}

/// Nodes, corners, sides and lines are taken whole; so are all nodes where all weigh the same, as
/// in the paper, whose loads are on three by three nodes.
TEST(PatchLoad, TakesNodesWholeWhereTheseAreMeant) {
  EXPECT_EQ(load_of(simulation_from_text(scene(21, R"({"node": 220})"))).nodes, 1);
  EXPECT_EQ(load_of(simulation_from_text(scene(21, R"({"boundary": "left"})"))).nodes, 21);
  EXPECT_EQ(load_of(simulation_from_text(scene(21, R"({"box": [[1, 0], [1, 1]]})"))).nodes, 21);
  const std::string paper = R"(, "differences": "forward", "border": "paper", "weights": "equal")";
  Simulation s =
      simulation_from_text(scene(21, R"({"centre": [0.5, 0.5], "radius": 0.06})", paper));
  const NodeValues f = s.system().terms().external_force(s.state()).col(2);
  EXPECT_EQ((f.array() != 0).count(), 9);
  EXPECT_EQ(f.maxCoeff(), f[220]);
  EXPECT_NEAR(f[220], 2.0 / 9, 1e-15);
  EXPECT_NEAR(f.sum(), 2, 1e-14);
}

/// A supported plate under the patch sags by the same on every grid, but for the differences' error
/// of second order; with whole nodes the sag changed by a tenth and back.
TEST(PatchLoad, SagsConverge) {
  const auto sag = [](int nodes) {
    Simulation s = simulation_from_text(
        scene(nodes, R"({"centre": [0.5, 0.5], "radius": 0.13})"),
        {{.pointer = "/energies", .value = R"([{"plugin": "thin_plate", "xi": 1}])"},
         {.pointer = "/constraints",
          .value = R"([{"plugin": "pin", "where": {"boundary": "all"}}])"},
         {.pointer = "/integrator", .value = R"({"plugin": "static", "step": 1})"}});
    s.step();
    return s.state().r.col(2).maxCoeff();
  };
  const double coarse = sag(11), middle = sag(21), fine = sag(41);
  EXPECT_LT(std::abs(middle - fine), 0.01 * fine);
  EXPECT_LT(std::abs(coarse - fine), 0.04 * fine);
}

}  // namespace
}  // namespace deform
