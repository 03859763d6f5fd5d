/// Steps that turn parts of a surface instead of stretching them.
#include <cmath>
#include <string>

#include <Eigen/Geometry>

#include "deform/solve/path.h"

#include "model/support/random.h"
#include "model/support/simulate.h"

namespace deform {
namespace {

using test::random_vectors;
using test::simulation_from_text;

/// Stiff and thin; what holds it is put in by pointers.
const std::string kStiff = R"({
  "surface": {"plugin": "grid", "nodes": [12, 7], "size": [0.12, 0.06], "differences": "symmetric",
              "border": "one_sided", "weights": "area"},
  "material": {"density": 0.4},
  "energies": [{"plugin": "koiter", "young": 1e9, "poisson": 0.2, "thickness": 0.0003}],
  "forces": [], "constraints": [],
  "integrator": {"plugin": "backward_euler", "step": 0.1}, "duration": 0.5})";
const Replacement kPinned{
    "/constraints/-", R"({"plugin": "pin", "where": {"corners": ["left_bottom", "left_top"]}})"};

/// ω × (r − c) for all nodes.
NodeVectors spin(const NodeVectors& r, const Vec3& omega, const Vec3& c) {
  NodeVectors d(r.rows(), 3);
  for (Index a = 0; a < r.rows(); ++a) d.row(a) = omega.cross(Vec3(r.row(a)) - c);
  return d;
}

TEST(RotationStrainPath, OfASpinIsARotationByThatAngle) {
  Simulation s = simulation_from_text(kStiff);
  const NodeVectors r = s.system().surface().initial();
  const Vec3 omega(0.3, -0.5, 0.7), moved(0.01, 0.02, -0.03), centre = r.colwise().mean();
  const NodeVectors d = spin(r, omega, centre).rowwise() + moved.transpose();
  Path path(s.system());
  path.begin(r, d, true);
  EXPECT_NEAR(path.angle(), omega.norm(), 1e-8);
  for (const double length : {0.1, 1.0, 2.0}) {
    NodeVectors found;
    path.at(length, found);
    const double angle = length * omega.norm();
    const Eigen::AngleAxisd rotation(angle, omega.normalized());
    for (Index a = 0; a < r.rows(); ++a) {
      const Vec3 expected = centre + rotation * (Vec3(r.row(a)) - centre) + length * moved;
      EXPECT_NEAR((Vec3(found.row(a)) - expected).norm(), 0, 1e-8) << "length " << length;
    }
  }
}

TEST(RotationStrainPath, AboutAHingeKeepsWhatIsHeldAndStretchesNothing) {
  Simulation s = simulation_from_text(kStiff, {kPinned});
  const NodeVectors r = s.system().surface().initial();
  const NodeVectors d = spin(r, Vec3::UnitY(), r.row(0));  // both corners lie on the axis
  Path path(s.system());
  path.begin(r, d, true);
  NodeVectors found;
  path.at(1.0, found);
  for (Index a = 0; a < r.rows(); ++a) {
    if (!s.system().constraints().reduction().free(a, 0)) {
      EXPECT_EQ(found.row(a), r.row(a));
    }
    for (Index b = 0; b < a; ++b)
      EXPECT_NEAR((found.row(a) - found.row(b)).norm(), (r.row(a) - r.row(b)).norm(), 1e-8);
  }
}

TEST(RotationStrainPath, IsStraightToFirstOrder) {
  Simulation s = simulation_from_text(kStiff, {kPinned});
  const NodeVectors r = s.system().surface().initial();
  NodeVectors d = 0.003 * random_vectors(r.rows(), 1);
  for (Index a = 0; a < r.rows(); ++a)
    if (!s.system().constraints().reduction().free(a, 0)) d.row(a).setZero();
  Path path(s.system());
  path.begin(r, d, true);
  const auto apart = [&](double length) {
    NodeVectors found;
    path.at(length, found);
    return (found - r - length * d).norm();
  };
  EXPECT_GT(apart(0.5), 0);
  EXPECT_NEAR(std::log2(apart(0.01) / apart(0.005)), 2, 0.02);
}

/// Iterations of the worst step; no step may have been halved.
std::int64_t worst_of(const std::vector<Replacement>& replacements) {
  Simulation s = simulation_from_text(kStiff, replacements);
  std::int64_t worst = 0;
  while (s.steps() < s.scene().steps()) {
    s.step();
    EXPECT_EQ(s.system().step_report().rejected, 0) << "step " << s.steps();
    worst = std::max<std::int64_t>(worst, s.system().step_report().iterations);
  }
  return worst;
}

// Each turns by a large angle in one step. Without turning steps, the first took 130 iterations and
// halved steps.
TEST(RotationStrainPath, LetsAStiffSheetTurnFarWithinAStep) {
  EXPECT_LE(worst_of({{"/forces/-", R"({"plugin": "spring", "anchor": [0.04, 0.07, -0.07],
                       "where": {"centre": [0.11, 0.03], "radius": 0.03}, "stiffness": 2})"}}),
            50);
  EXPECT_LE(worst_of({kPinned, {"/forces/-", R"({"plugin": "gravity"})"}}), 30);
  EXPECT_LE(worst_of({kPinned, {"/forces/-", R"({"plugin": "pressure", "pressure": 2})"}}), 50);
}

// Nothing holds it, so that its links are known but for translations: an iterative solver's matrix
// is singular (it takes over at a thousand nodes).
TEST(RotationStrainPath, ALargeFreeSheetFallsWithoutHalvingItsSteps) {
  for (const char* integrator : {"backward_euler", "bdf2", "implicit_midpoint"}) {
    Simulation s = simulation_from_text(
        kStiff, {{"/surface/nodes", "[41, 41]"},
                 {"/surface/size", "[1, 1]"},
                 {"/material/density", "0.2"},
                 {"/energies/0",
                  R"({"plugin": "koiter", "young": 1e5, "poisson": 0.3, "thickness": 1e-3})"},
                 {"/forces/-", R"({"plugin": "gravity"})"},
                 {"/integrator", std::string(R"({"plugin": ")") + integrator +
                                     R"(", "step": 0.01, "tolerance": 1e-6})"},
                 {"/duration", "0.1"}});
    while (s.steps() < s.scene().steps()) {
      s.step();
      EXPECT_EQ(s.system().step_report().rejected, 0) << integrator << ", step " << s.steps();
    }
    // ½ g t², and half a step's way more by the method of first order.
    const double ahead = std::string(integrator) == "implicit_midpoint" ? 0 : 0.5 * 9.81 * 0.001;
    const NodeVectors fallen = s.state().r - s.system().surface().initial();
    EXPECT_NEAR(fallen.col(2).maxCoeff(), -0.5 * 9.81 * 0.01, ahead + 1e-6) << integrator;
    EXPECT_NEAR(fallen.col(2).minCoeff(), fallen.col(2).maxCoeff(), 1e-6) << integrator;
  }
}

// Drag far above inertia: c A dt is forty masses.
TEST(RotationStrainPath, StrongDragIsTakenWithItsDerivative) {
  EXPECT_LE(worst_of({kPinned,
                      {"/forces/-", R"({"plugin": "gravity", "acceleration": [0, 0, -1]})"},
                      {"/forces/-", R"({"plugin": "viscous_fluid", "viscosity": 160})"}}),
            15);
}

}  // namespace
}  // namespace deform
