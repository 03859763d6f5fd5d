#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "deform/error.h"
#include "deform/surface/surface.h"

#include "support/fake_surface.h"

namespace deform {
namespace {

using testing::HasSubstr;
using Nodes = std::vector<Index>;

NodeSelector centre(const Vec2& at, double radius) {
  NodeSelector selector{.form = NodeSelector::Form::centre};
  selector.centre = at;
  selector.radius = radius;
  return selector;
}

NodeSelector box(const Vec2& lower, const Vec2& upper) {
  NodeSelector selector{.form = NodeSelector::Form::box};
  selector.lower = lower;
  selector.upper = upper;
  return selector;
}

NodeSelector named(NodeSelector::Form form, std::vector<std::string> names) {
  NodeSelector selector{.form = form};
  selector.names = std::move(names);
  return selector;
}

constexpr auto kBoundary = NodeSelector::Form::boundary;
constexpr auto kCorners = NodeSelector::Form::corners;

class Selection : public testing::Test {
 protected:
  [[nodiscard]] Nodes select(std::vector<NodeSelector> selectors) const {
    return select_nodes(surface_, {std::move(selectors)});
  }
  [[nodiscard]] std::string error_of(std::vector<NodeSelector> selectors) const {
    try {
      (void)select(std::move(selectors));
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  }

  test::FakeSurface surface_{11, 3};  // Spacing 0.1.
};

TEST_F(Selection, CentreTakesTheRimWhateverTheRounding) {
  // 0.3 − 0.1 and 0.1 + 0.2 are not the doubles 0.2 and 0.3.
  EXPECT_EQ(select({centre({0.3, 0}, 0.1)}), (Nodes{2, 3, 4, 13, 14, 15}));
  EXPECT_EQ(select({centre({0.1 + 0.2, 0.1}, 0)}), (Nodes{14}));
  EXPECT_EQ(select({centre({0.3, 0}, 0.0999)}), (Nodes{3}));
}

TEST_F(Selection, CentreUsesTheMaximumNorm) {
  EXPECT_EQ(select({centre({0.5, 0.1}, 0.1)}).size(), 9U);
}

TEST_F(Selection, BoxIsClosed) {
  EXPECT_EQ(select({box({0.2, 0.1}, {0.3, 0.2})}), (Nodes{13, 14, 24, 25}));
  EXPECT_EQ(select({box({0.1 + 0.2, 0}, {0.1 + 0.2, 0})}), (Nodes{3}));
}

TEST_F(Selection, TakesNamedPartsAndAllOfThem) {
  EXPECT_EQ(select({named(kBoundary, {"left"})}), (Nodes{0, 11, 22}));
  EXPECT_EQ(select({named(kBoundary, {"all"})}), (Nodes{0, 10, 11, 21, 22, 32}));
  EXPECT_EQ(select({named(kCorners, {"all"})}), (Nodes{0}));
}

TEST(PeriodicSelection, ReachesOverTheSeam) {
  test::FakeSurface surface(11, 3);
  surface.set_period(1.1);  // node 10 is next to node 0
  EXPECT_EQ(select_nodes(surface, {{centre({0, 0.1}, 0.11)}}),
            (Nodes{0, 1, 10, 11, 12, 21, 22, 23, 32}));
  EXPECT_EQ(select_nodes(surface, {{box({0.95, 0}, {1.15, 0})}}), (Nodes{0, 10}));
}

TEST_F(Selection, IsAUnionWithoutRepetition) {
  EXPECT_EQ(select({test::nodes_numbered({5, 0}).selectors[0], named(kBoundary, {"left"})}),
            (Nodes{0, 5, 11, 22}));
}

TEST_F(Selection, RejectsUnknownNamesWithTheNearest) {
  const std::string error = error_of({named(kBoundary, {"lfet"}), named(kCorners, {"frist"})});
  EXPECT_THAT(error, HasSubstr("no boundary \"lfet\"; did you mean \"left\"?"));
  EXPECT_THAT(error, HasSubstr("no corner \"frist\"; did you mean \"first\"?"));
}

TEST_F(Selection, RejectsNumbersThatAreNoNodes) {
  EXPECT_THAT(error_of({test::nodes_numbered({33}).selectors[0]}), HasSubstr("no node 33"));
  EXPECT_THAT(error_of({test::nodes_numbered({-1}).selectors[0]}), HasSubstr("0 to 32"));
}

TEST_F(Selection, RejectsASelectionOfNoNode) {
  EXPECT_THAT(error_of({centre({5, 5}, 0.1)}),
              HasSubstr("selects no node of the surface, whose parameters are [0, 0] to [1, 0.2]"));
  EXPECT_THAT(error_of({}), HasSubstr("selects no node"));
}

}  // namespace
}  // namespace deform
