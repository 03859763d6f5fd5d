#include <algorithm>
#include <set>

#include <gtest/gtest.h>

#include "deform/model/energy_term.h"

#include "support/builtin.h"
#include "support/fake_surface.h"

namespace deform {
namespace {

using test::make_builtin;
using test::parameters;

class EdgeSprings : public testing::Test {
 public:
  EdgeSprings() : setup(test::bare_setup()) {
    setup.with_surface(surface, surface.rest(), surface.areas());
  }

  [[nodiscard]] std::shared_ptr<TupleTerm> make(bool diagonals) const {
    return make_builtin<TupleTerm>(
        "edge_springs", parameters({{"stiffness", Field(2.0)}, {"diagonals", diagonals}}), setup);
  }
  // One block, or two, of which the second does not begin at 0.
  template <class Visit>
  void visit_blocks(const TupleTerm& term, const NodeVectors& r, Visit visit) const {
    const auto springs = static_cast<Index>(term.tuples().size() / 2);
    for (const auto& [first, size] : {std::pair<Index, Index>{0, 7}, {7, springs - 7}})
      visit(TupleBlock{first, size, 2, term.tuples().data() + 2 * first, &r, &r});
  }
  [[nodiscard]] double energy_of(const TupleTerm& term, const NodeVectors& r) const {
    double sum = 0;
    visit_blocks(term, r, [&](const TupleBlock& block) {
      std::vector<double> energy(static_cast<std::size_t>(block.size));
      term.energy(block, energy);
      for (const double e : energy) sum += e;
    });
    return sum;
  }
  [[nodiscard]] NodeVectors force_of(const TupleTerm& term, const NodeVectors& r) const {
    NodeVectors force = NodeVectors::Zero(r.rows(), 3);
    visit_blocks(term, r, [&](const TupleBlock& block) {
      std::vector<double> k(static_cast<std::size_t>(4 * block.size));
      std::vector<Vec3> c(static_cast<std::size_t>(2 * block.size), Vec3::Zero());
      term.affine_force(block, k, c);
      for (Index i = 0; i < block.size; ++i)
        for (int a = 0; a < 2; ++a) {
          force.row(block.node(i, a)) -= c[2 * i + a];
          for (int b = 0; b < 2; ++b)
            force.row(block.node(i, a)) -= k[4 * i + 2 * a + b] * block.r(i, b);
        }
    });
    return force;
  }

  test::FakeSurface surface{4, 3};
  deform::Setup setup;
};

TEST_F(EdgeSprings, LieAlongEdgesAndDiagonalsOnce) {
  const std::size_t edges = 3 * 3 + 4 * 2, diagonals = 2 * 3 * 2;
  EXPECT_EQ(make(false)->tuples().size(), 2 * edges);
  const auto term = make(true);
  EXPECT_EQ(term->tuples().size(), 2 * (edges + diagonals));
  std::set<std::pair<int, int>> pairs;
  for (std::size_t i = 0; i < term->tuples().size(); i += 2)
    pairs.insert(std::minmax(term->tuples()[i], term->tuples()[i + 1]));
  EXPECT_EQ(pairs.size(), edges + diagonals);
}

TEST_F(EdgeSprings, RestAtRest) {
  const auto term = make(true);
  EXPECT_EQ(energy_of(*term, surface.rest()), 0);
  EXPECT_EQ(force_of(*term, surface.rest()).norm(), 0);
}

TEST_F(EdgeSprings, StretchedSpringHasItsEnergy) {
  const auto term = make(false);
  NodeVectors r = surface.rest();
  r.col(0) *= 1.5;  // nine edges along x, each 1/3 long
  EXPECT_NEAR(energy_of(*term, r), 9 * 0.5 * 2.0 / 36, 1e-14);
}

// Central differences with steps of 1e-5: their error is about 1e-9.
TEST_F(EdgeSprings, ForceIsMinusTheGradient) {
  const auto term = make(true);
  ASSERT_TRUE(term->traits().potential);
  NodeVectors r = surface.rest() + 0.1 * NodeVectors::Random(surface.nodes(), 3);
  const NodeVectors force = force_of(*term, r);
  const double h = 1e-5;
  for (Index i = 0; i < r.size(); ++i) {
    const double x = r.data()[i];
    r.data()[i] = x + h;
    const double above = energy_of(*term, r);
    r.data()[i] = x - h;
    const double below = energy_of(*term, r);
    r.data()[i] = x;
    EXPECT_NEAR(force.data()[i], -(above - below) / (2 * h), 1e-8);
  }
}

TEST_F(EdgeSprings, CollapsedSpringIsFinite) {
  const auto term = make(true);
  NodeVectors r = surface.rest();
  r.row(1) = r.row(0);
  EXPECT_TRUE(force_of(*term, r).allFinite());
}

// Every spring doubled in length stores ½ k L0², with the mean k of its nodes: linear in a1, so
// that the sheet's symmetric springs have together what the value in the middle would give.
TEST_F(EdgeSprings, MayVaryOverTheSheet) {
  const auto term = [this](const Field& stiffness) {
    return make_builtin<TupleTerm>("edge_springs", parameters({{"stiffness", stiffness}}), setup);
  };
  const NodeVectors twice = 2 * surface.rest();
  const double constant = energy_of(*term(2.0), twice);
  EXPECT_NEAR(energy_of(*term(Field::formula("1 + 2*a1")), twice), constant, 1e-14 * constant);
  EXPECT_LT(force_of(*term(2.0), twice).colwise().sum().norm(), 1e-14);
  const NodeVectors force = force_of(*term(Field::formula("1 + 2*a1")), twice);
  EXPECT_LT(force.colwise().sum().norm(), 1e-14);
  EXPECT_GT(force.row(3).norm(), force.row(0).norm());  // stiffer on the right
}

}  // namespace
}  // namespace deform
