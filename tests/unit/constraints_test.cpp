#include <gtest/gtest.h>

#include "deform/model/constraint.h"

#include "support/builtin.h"
#include "support/fake_surface.h"

namespace deform {
namespace {

using test::make_builtin;
using test::nodes_numbered;
using test::parameters;

using Names = std::vector<std::string>;

class Constraints : public testing::Test {
 public:
  Constraints() : setup(test::bare_setup()) {
    initial = NodeVectors::Random(surface.nodes(), 3);
    surface.set_initial(initial);
    setup.with_surface(surface, surface.rest(), surface.areas());
  }

  // Where the constraint puts nodes that are all far away.
  [[nodiscard]] NodeVectors prescribed(const Constraint& constraint, double time) const {
    NodeVectors r = NodeVectors::Constant(surface.nodes(), 3, kAway);
    constraint.prescribe(time, r);
    return r;
  }
  // What reduce() takes away is what prescribe() writes.
  void expect_consistent(const Constraint& constraint) const {
    Reduction reduction(surface.nodes());
    constraint.reduce(reduction);
    const NodeVectors r = prescribed(constraint, 0.7);
    for (Index a = 0; a < surface.nodes(); ++a)
      for (int c = 0; c < 3; ++c) EXPECT_EQ(reduction.prescribed(a, c), r(a, c) != kAway);
  }

  static constexpr double kAway = 1000;
  test::FakeSurface surface{4, 3};
  NodeVectors initial;
  deform::Setup setup;
};

TEST_F(Constraints, PinHoldsInitialPositions) {
  const auto pin =
      make_builtin<Constraint>("pin", parameters({{"where", nodes_numbered({2, 7})}}), setup);
  const NodeVectors r = prescribed(*pin, 3);
  NodeVectors expected = NodeVectors::Constant(surface.nodes(), 3, kAway);
  for (const Index node : {2, 7}) expected.row(node) = initial.row(node);
  EXPECT_EQ(r, expected);
  expect_consistent(*pin);
}

TEST_F(Constraints, PinHoldsSingleComponents) {
  const auto pin = make_builtin<Constraint>(
      "pin", parameters({{"where", nodes_numbered({2})}, {"components", Names{"z", "x"}}}), setup);
  const NodeVectors r = prescribed(*pin, 0);
  EXPECT_EQ(r.row(2), Eigen::RowVector3d(initial(2, 0), kAway, initial(2, 2)));
  expect_consistent(*pin);
}

TEST_F(Constraints, RefuseToConstrainNothing) {
  const ParameterValues no_component =
      parameters({{"where", nodes_numbered({2})},
                  {"components", Names{}},
                  {"times", std::vector<double>{0}},
                  {"displacements", std::vector<Vec3>{Vec3::Zero()}}});
  const ParameterValues no_node = parameters(
      {{"times", std::vector<double>{0}}, {"displacements", std::vector<Vec3>{Vec3::Zero()}}});
  for (const char* name : {"pin", "move"}) {
    EXPECT_THROW((void)make_builtin<Constraint>(name, no_component, setup), InputError) << name;
    EXPECT_THROW((void)make_builtin<Constraint>(name, no_node, setup), InputError) << name;
  }
}

TEST_F(Constraints, MoveFollowsItsPath) {
  const auto move = make_builtin<Constraint>(
      "move",
      parameters({{"where", nodes_numbered({1, 4})},
                  {"components", Names{"x", "z"}},
                  {"times", std::vector<double>{1, 2, 4}},
                  {"displacements", std::vector<Vec3>{{0, 0, 1}, {1, 9, 2}, {1, 9, -2}}}}),
      setup);
  expect_consistent(*move);
  const std::vector<std::pair<double, Vec3>> path{
      {0, {0, 0, 1}}, {1, {0, 0, 1}},  {1.5, {0.5, 0, 1.5}}, {2, {1, 0, 2}},
      {3, {1, 0, 0}}, {4, {1, 0, -2}}, {100, {1, 0, -2}}};
  for (const auto& [time, u] : path)
    for (const Index node : {1, 4}) {
      const Eigen::RowVector3d r = prescribed(*move, time).row(node);
      EXPECT_DOUBLE_EQ(r.x(), initial(node, 0) + u.x()) << time;
      EXPECT_DOUBLE_EQ(r.z(), initial(node, 2) + u.z()) << time;
      EXPECT_EQ(r.y(), kAway);
    }
}

TEST_F(Constraints, MoveWithOnePointHoldsStill) {
  const auto move =
      make_builtin<Constraint>("move",
                               parameters({{"where", nodes_numbered({1})},
                                           {"times", std::vector<double>{1}},
                                           {"displacements", std::vector<Vec3>{{0, 0, 1}}}}),
                               setup);
  for (const double time : {0.0, 1.0, 2.0})
    EXPECT_EQ(prescribed(*move, time)(1, 2), initial(1, 2) + 1);
}

TEST_F(Constraints, MoveRefusesBrokenPaths) {
  const auto make = [this](std::vector<double> times, std::vector<Vec3> displacements) {
    (void)make_builtin<Constraint>("move",
                                   parameters({{"where", nodes_numbered({1})},
                                               {"times", std::move(times)},
                                               {"displacements", std::move(displacements)}}),
                                   setup);
  };
  const Vec3 u = Vec3::Zero();
  EXPECT_NO_THROW(make({0, 1}, {u, u}));
  EXPECT_THROW(make({}, {}), InputError);
  EXPECT_THROW(make({0, 1}, {u}), InputError);
  EXPECT_THROW(make({0, 1, 1}, {u, u, u}), InputError);
  EXPECT_THROW(make({0, 2, 1}, {u, u, u}), InputError);
}

}  // namespace
}  // namespace deform
