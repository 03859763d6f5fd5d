/// Geometry as far as it is read: what is computed has the bits of everything, what is left out is
/// not a number, and what is completed is everything.
#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "model/support/simulate.h"

namespace deform {
namespace {

/// Curved, with samples inside and at the sides.
Simulation sheet() {
  return test::simulation_from_text(
      R"({"surface": {"plugin": "grid", "nodes": [9, 7],
                    "initial": {"plugin": "wave", "amplitude": 0.1, "wavelength": 0.7}},
        "energies": [{"plugin": "stretching", "eta": [[1, 0], [0, 1]]}],
        "integrator": {"plugin": "semi_implicit", "step": 0.01}, "duration": 0.01})");
}

class GeometryDetail : public testing::Test {
 protected:
  Simulation simulation_ = sheet();
  const SampleSet& samples_ = simulation_.system().surface().samples(SampleRole::membrane);
  const NodeVectors& r_ = simulation_.state().r;

  [[nodiscard]] Geometry of(Geometry::Detail detail) const {
    Geometry geometry(samples_);
    geometry.compute(samples_, r_, detail);
    return geometry;
  }
};

using Numbers = std::vector<double>;

void append(ConstValues values, Numbers& to) { to.insert(to.end(), values.begin(), values.end()); }
void append(const ConstVectors& vectors, Index size, Numbers& to) {
  for (Index s = 0; s < size; ++s)
    for (Index c = 0; c < 3; ++c) to.push_back(vectors[s][c]);
}

/// r_1, r_2, G_ij.
Numbers metric(const GeometryBlock& block) {
  Numbers all;
  for (const Derivative d : {Derivative::d1, Derivative::d2}) append(block.r(d), block.size(), all);
  for (const Pair ij : kPairs) append(block.G(ij), all);
  return all;
}

/// n, G^ij, the area element.
Numbers frame(const GeometryBlock& block) {
  Numbers all;
  append(block.n(), block.size(), all);
  for (const Pair ij : kPairs) append(block.reciprocal(ij), all);
  append(block.area_element(), all);
  return all;
}

/// r_ij, B_ij, Γ^k_ij.
Numbers curvature(const GeometryBlock& block) {
  Numbers all;
  for (const Pair ij : kPairs) {
    append(block.r(ij), block.size(), all);
    append(block.B(ij), all);
    for (const int k : {1, 2}) append(block.gamma(k, ij), all);
  }
  return all;
}

bool is_nothing(const Numbers& numbers) {
  return std::ranges::all_of(numbers, [](double x) { return std::isnan(x); });
}

TEST_F(GeometryDetail, IsThatOfEverythingAsFarAsItGoes) {
  const Geometry whole = of(Geometry::Detail::second), first = of(Geometry::Detail::first),
                 alone = of(Geometry::Detail::metric);
  EXPECT_EQ(metric(first.all()), metric(whole.all()));
  EXPECT_EQ(frame(first.all()), frame(whole.all()));
  EXPECT_TRUE(is_nothing(curvature(first.all())));
  EXPECT_EQ(metric(alone.all()), metric(whole.all()));
  EXPECT_TRUE(is_nothing(frame(alone.all())));
  EXPECT_TRUE(is_nothing(curvature(alone.all())));
}

TEST_F(GeometryDetail, CompletesToEverything) {
  const Geometry all = of(Geometry::Detail::second);
  for (const auto detail :
       {Geometry::Detail::none, Geometry::Detail::metric, Geometry::Detail::first}) {
    Geometry geometry = of(detail);
    geometry.complete(samples_, r_);
    EXPECT_EQ(metric(geometry.all()), metric(all.all()));
    EXPECT_EQ(frame(geometry.all()), frame(all.all()));
    EXPECT_EQ(curvature(geometry.all()), curvature(all.all()));
  }
}

TEST_F(GeometryDetail, InPiecesIsTheSame) {
  const Geometry all = of(Geometry::Detail::second);
  Geometry geometry(samples_);
  geometry.begin(Geometry::Detail::second);
  for (Index first = 0; first < samples_.size(); first += 5)
    geometry.compute(samples_, r_, first, std::min<Index>(5, samples_.size() - first));
  EXPECT_EQ(metric(geometry.all()), metric(all.all()));
  EXPECT_EQ(frame(geometry.all()), frame(all.all()));
  EXPECT_EQ(curvature(geometry.all()), curvature(all.all()));
}

/// Nobody may read what is of the state before.
TEST_F(GeometryDetail, LeavesNothingOfAnEarlierStateBehind) {
  Geometry geometry = of(Geometry::Detail::second);
  geometry.compute(samples_, r_, Geometry::Detail::first);
  EXPECT_EQ(metric(geometry.all()), metric(of(Geometry::Detail::second).all()));
  EXPECT_TRUE(is_nothing(curvature(geometry.all())));
  geometry.compute(samples_, r_, Geometry::Detail::metric);
  EXPECT_EQ(metric(geometry.all()), metric(of(Geometry::Detail::second).all()));
  EXPECT_TRUE(is_nothing(frame(geometry.all())));
  geometry.compute(samples_, r_, Geometry::Detail::none);
  EXPECT_TRUE(is_nothing(curvature(geometry.all())));
  EXPECT_TRUE(is_nothing(frame(geometry.all())));
  EXPECT_TRUE(is_nothing(metric(geometry.all())));
}

}  // namespace
}  // namespace deform
