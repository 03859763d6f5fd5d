/// The parts of a comparison: names and values of a grid, places on another mesh, distances,
/// claims.
#include <cmath>
#include <fstream>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "deform/compare/plan.h"
#include "deform/error.h"

#include "compare/differences.h"
#include "compare/expectation.h"
#include "compare/hausdorff.h"
#include "compare/mesh_map.h"
#include "compare/run_names.h"
#include "compare/verdict.h"

namespace deform {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

/// n_1 × n_2 nodes on [0, 1] × [0, 1].
TrajectoryMesh unit_square(Index n_1, Index n_2) {
  TrajectoryMesh mesh;
  mesh.parameters.resize(n_1 * n_2, 2);
  mesh.areas = NodeValues::Constant(n_1 * n_2, 1.0 / static_cast<double>(n_1 * n_2));
  for (Index j = 0; j < n_2; ++j)
    for (Index i = 0; i < n_1; ++i)
      mesh.parameters.row(i + n_1 * j) << static_cast<double>(i) / static_cast<double>(n_1 - 1),
          static_cast<double>(j) / static_cast<double>(n_2 - 1);
  for (Index j = 0; j + 1 < n_2; ++j)
    for (Index i = 0; i + 1 < n_1; ++i) {
      for (const Index k : {i + n_1 * j, i + 1 + n_1 * j, i + 1 + n_1 * (j + 1), i + n_1 * (j + 1)})
        mesh.faces.nodes.push_back(static_cast<std::int32_t>(k));
      mesh.faces.begin.push_back(static_cast<std::int32_t>(mesh.faces.nodes.size()));
    }
  mesh.size = 1;
  return mesh;
}

TEST(SplitValues, KeepsBracketsAndQuotesTogether) {
  EXPECT_THAT(split_values("gauss,exact"), ElementsAre("gauss", "exact"));
  EXPECT_THAT(split_values("[9,9],[17,17]"), ElementsAre("[9,9]", "[17,17]"));
  EXPECT_THAT(split_values(R"({"plugin":"gauss","delta":1},"a,\"b",1)"),
              ElementsAre(R"({"plugin":"gauss","delta":1})", R"("a,\"b")", "1"));
  EXPECT_THAT(split_values(""), ElementsAre(""));
}

TEST(ValueLabels, AreAsShortAsTheyCanBe) {
  const auto labels = value_labels({{"/energies/1/normal/plugin", {"gauss", "exact"}},
                                    {"/energies/1/xi", {"1e-6", "[[1,0],[0,1]]"}}});
  EXPECT_THAT(labels, ElementsAre(ElementsAre("normal=gauss", "normal=exact"),
                                  ElementsAre("xi=1e-6", "xi=1_0_0_1")));
}

TEST(ValueLabels, TellEqualKeysAndValuesApart) {
  const auto labels =
      value_labels({{"/energies/0/eta", {"1", "1.0"}}, {"/energies/1/eta", {"1", "1"}}});
  EXPECT_THAT(labels, ElementsAre(ElementsAre("0.eta=1", "0.eta=1.0"),
                                  ElementsAre("1.eta=1", "1.eta=1-2")));
}

TEST(MeshMap, HitsNodesOfAFinerMeshExactly) {
  const TrajectoryMesh fine = unit_square(17, 9), coarse = unit_square(9, 5);
  const NodeVectors r = NodeVectors::Random(fine.areas.size(), 3);
  const NodeVectors at = MeshMap(fine, coarse.parameters).apply(r);
  for (Index j = 0; j < 5; ++j)
    for (Index i = 0; i < 9; ++i) EXPECT_EQ(at.row(i + 9 * j), r.row(2 * i + 17 * 2 * j));
}

TEST(MeshMap, IsExactForWhatIsLinear) {
  const TrajectoryMesh mesh = unit_square(6, 7), other = unit_square(10, 11);
  const auto plane = [](const Eigen::MatrixX2d& a) {
    NodeVectors r(a.rows(), 3);
    r << a.col(0), 2 * a.col(1), 3 * a.col(0) - a.col(1);
    return r;
  };
  const MeshMap map(mesh, other.parameters);
  EXPECT_FALSE(map.is_identity());
  EXPECT_LT((map.apply(plane(mesh.parameters)) - plane(other.parameters)).cwiseAbs().maxCoeff(),
            1e-14);
}

TEST(MeshMap, IsTheIdentityOnTheSameMesh) {
  const TrajectoryMesh mesh = unit_square(4, 4);
  EXPECT_TRUE(MeshMap(mesh, mesh.parameters).is_identity());
}

TEST(MeshMap, RefusesPlacesOutside) {
  const TrajectoryMesh mesh = unit_square(4, 4);
  Eigen::MatrixX2d place(1, 2);
  place << 1.5, 0.5;
  EXPECT_THROW(MeshMap(mesh, place), InputError);
}

TEST(SquaredDistance, IsThatOfTheNearestPoint) {
  const Vec3 a(0, 0, 0), b(1, 0, 0), c(0, 1, 0);
  EXPECT_DOUBLE_EQ(squared_distance({0.2, 0.2, 0.5}, a, b, c), 0.25);  // above the face
  EXPECT_DOUBLE_EQ(squared_distance({0.5, -2, 0}, a, b, c), 4);        // beside an edge
  EXPECT_DOUBLE_EQ(squared_distance({-3, -4, 0}, a, b, c), 25);        // at a corner
  EXPECT_DOUBLE_EQ(squared_distance({1, 1, 0}, a, b, c), 0.5);         // at the long edge
  EXPECT_DOUBLE_EQ(squared_distance({0.5, 3, 0}, a, b, b), 9);         // a triangle without area
}

/// Without trees, bounds or short cuts.
double brute_hausdorff(const NodeVectors& a, const NodeVectors& b,
                       const std::vector<Triangle>& faces) {
  const auto one_way = [&faces](const NodeVectors& from, const NodeVectors& to) {
    double greatest = 0;
    for (Index i = 0; i < from.rows(); ++i) {
      double least = kInfinity;
      for (const Triangle& f : faces)
        least =
            std::min(least, squared_distance(from.row(i).transpose(), to.row(f[0]).transpose(),
                                             to.row(f[1]).transpose(), to.row(f[2]).transpose()));
      greatest = std::max(greatest, least);
    }
    return greatest;
  };
  return std::sqrt(std::max(one_way(a, b), one_way(b, a)));
}

TEST(Hausdorff, AgreesWithTryingEverything) {
  const TrajectoryMesh mesh = unit_square(8, 7);
  const std::vector<Triangle> faces = triangles_of(mesh.faces);
  std::mt19937 random(7);
  std::normal_distribution<double> noise(0, 0.1);
  for (int trial = 0; trial < 20; ++trial) {
    NodeVectors a(mesh.areas.size(), 3), b = a;
    for (Index i = 0; i < a.rows(); ++i) {
      a.row(i) << mesh.parameters(i, 0) + noise(random), mesh.parameters(i, 1), noise(random);
      b.row(i) << mesh.parameters(i, 0), mesh.parameters(i, 1) + noise(random), noise(random);
    }
    const NodeValues near = (a - b).rowwise().norm();
    EXPECT_DOUBLE_EQ(hausdorff_distance(a, faces, near, b, faces, near),
                     brute_hausdorff(a, b, faces));
  }
}

TEST(Hausdorff, OfASurfaceMovedWithinItselfIsThatOfItsBorder) {
  const TrajectoryMesh mesh = unit_square(11, 11);
  const std::vector<Triangle> faces = triangles_of(mesh.faces);
  NodeVectors a = NodeVectors::Zero(121, 3);
  a.leftCols(2) = mesh.parameters;
  NodeVectors b = a;
  b.col(0).array() += 0.03;  // every node moves by as much
  const NodeValues near = (a - b).rowwise().norm();
  EXPECT_NEAR(hausdorff_distance(a, faces, near, b, faces, near), 0.03, 1e-15);
  b = a;
  for (Index i = 0; i < 121; ++i)  // only inner nodes move: the set of points stays
    if (a(i, 0) > 0.05 && a(i, 0) < 0.95) b(i, 0) += 0.03;
  const NodeValues inner = (a - b).rowwise().norm();
  EXPECT_NEAR(hausdorff_distance(a, faces, inner, b, faces, inner), 0, 1e-15);
}

TEST(SameTimes, MatchThroughRounding) {
  std::vector<Moment> a, b;
  for (int i = 0; i <= 10; ++i) a.push_back({i, i * 0.1});
  double t = 0;
  for (int i = 0; i <= 40; ++i, t += 0.025) b.push_back({i, t});
  const auto pairs = same_times(a, b);
  ASSERT_EQ(pairs.size(), 11U);
  for (std::size_t i = 0; i < pairs.size(); ++i) EXPECT_EQ(pairs[i], std::make_pair(i, 4 * i));
}

TEST(SameTimes, OfSingleMomentsAreSoInAnyUnit) {
  for (const double unit : {1e-12, 1.0, 1e9}) {
    EXPECT_EQ(same_times({{1, 0.3 * unit}}, {{4, 0.3 * (1 + 1e-15) * unit}}).size(), 1U);
    EXPECT_EQ(same_times({{1, 0.3 * unit}}, {{1, 0.4 * unit}}).size(), 0U);
    EXPECT_EQ(same_times({{0, 0}}, {{1, unit}}).size(), 0U);
  }
}

TEST(LengthText, HasAPrefix) {
  EXPECT_EQ(length_text(0.1123), "112 mm");
  EXPECT_EQ(length_text(2.5), "2.5 m");
  EXPECT_EQ(length_text(3.21e-6), "3.21 µm");
  EXPECT_EQ(length_text(0), "0 m");
  EXPECT_EQ(length_text(0.9999), "1 m");
}

class Claims : public ::testing::Test {
 protected:
  static bool holds(const std::string& claim) {
    RunComparison gauss, xi;
    gauss.name = "gauss";
    gauss.figures = {{"flatness", "1", 0.25}, {"energy.bending", "J", 2}};
    xi.name = "xi=1e-7+n=2.5";
    xi.figures = {{"flatness", "1", 0.5}, {"lowest", "m", std::nan("")}};
    Comparison comparison;
    comparison.runs = {gauss, xi};
    return check_claims({claim}, comparison).front().holds;
  }
};

TEST_F(Claims, CompareFiguresOfRuns) {
  EXPECT_TRUE(holds("gauss.flatness < xi=1e-7+n=2.5.flatness"));
  EXPECT_FALSE(holds("gauss.flatness > xi=1e-7+n=2.5.flatness"));
  EXPECT_TRUE(holds("2 * gauss.flatness == xi=1e-7+n=2.5.flatness"));
  EXPECT_TRUE(holds("abs(gauss.flatness-0.25)<=1e-12 && gauss.energy.bending == 2"));
  EXPECT_FALSE(holds("gauss.flatness < 0.1 || gauss.flatness > 0.3"));
}

TEST_F(Claims, DoNotHoldWhereAFigureIsMissing) {
  EXPECT_FALSE(holds("xi=1e-7+n=2.5.lowest < 1"));
  EXPECT_FALSE(holds("xi=1e-7+n=2.5.lowest < 1 || 1 == 1"));
  EXPECT_FALSE(holds("gauss.nothing != 0"));
}

}  // namespace
}  // namespace deform
