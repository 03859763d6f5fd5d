/// Every energy term against finite differences of its energy, rigid motions, momenta, and the rule
/// of the lagged operator.
#include <cmath>
#include <cstdio>

#include <Eigen/Geometry>

#include "deform/check/mechanics.h"

#include "model/support/simulate.h"

namespace deform {
namespace {

using test::simulation_from_text;

std::string scene(const std::string& energy, const std::string& grid, const std::string& rest) {
  return R"({"surface": {"plugin": "grid", "nodes": [9, 7], "size": [1.0, 0.8], )" + grid +
         R"(, "rest": )" + rest + R"(}, "material": {"density": 0.1}, "energies": [)" + energy +
         R"(], "integrator": {"plugin": "semi_implicit", "step": 0.01}, "duration": 0.01})";
}

const std::string kOneSided =
    R"("differences": "forward", "border": "one_sided", "weights": "equal")";
const std::string kCentral =
    R"("differences": "central", "border": "one_sided", "weights": "area")";
const std::string kSymmetric =
    R"("differences": "symmetric", "border": "one_sided", "weights": "area")";
const std::string kSymmetricTube = kSymmetric + R"(, "periodic": [true, false])";
const std::string kPaper = R"("differences": "forward", "border": "paper", "weights": "equal")";
const std::string kForwardArea =
    R"("differences": "forward", "border": "one_sided", "weights": "area")";
const std::string kTube =
    R"("differences": "forward", "border": "one_sided", "weights": "area", "periodic": [true, false])";
const std::string kCircle = R"({"plugin": "arc", "radius": 0.15915494309189535})";
const std::string kFlat = R"({"plugin": "flat"})";
const std::string kArc = R"({"plugin": "arc", "radius": 0.5})";
const std::string kSphere = R"({"plugin": "sphere_patch", "radius": 1.5})";

std::string bending(const std::string& normal, const std::string& form) {
  return R"({"plugin": "bending", "xi": [[2e-4, 1e-4], [1e-4, 3e-4]], "form": ")" + form +
         R"(", "normal": )" + normal + "}";
}
const std::string kStretching =
    R"({"plugin": "stretching", "eta": [[0.02, 0.005], [0.005, 0.01]]})";
const std::string kVariational =
    R"({"plugin": "bending_variational", "xi": [[2e-4, 1e-4], [1e-4, 3e-4]]})";
const std::string kSprings = R"({"plugin": "edge_springs", "stiffness": 2.0})";
const std::string kGauss = R"({"plugin": "gauss", "delta": 0})";
const std::string kExact = R"({"plugin": "exact"})";
const std::string kTerzopoulos = R"({"plugin": "terzopoulos"})";

/// The rest state of a simulation with a disturbance of relative size `strain`.
State disturbed(Simulation& s, double strain) {
  return deform::disturbed(s.system().rest(), strain);
}

std::string scientific(double x) {
  char text[32];
  std::snprintf(text, sizeof text, "%.1e", x);
  return text;
}

struct PotentialCase {
  std::string name, energy, grid, rest;
  friend void PrintTo(const PotentialCase& c, std::ostream* out) { *out << c.name; }
};
class PotentialTest : public testing::TestWithParam<PotentialCase> {};

TEST_P(PotentialTest, ForceIsMinusTheGradientOfTheEnergy) {
  const PotentialCase& p = GetParam();
  Simulation s = simulation_from_text(scene(p.energy, p.grid, p.rest));
  const double error = gradient_error(s.system(), 0, disturbed(s, 0.1));
  EXPECT_LT(error, 1e-6);
  RecordProperty("relative_error", scientific(error));
}

INSTANTIATE_TEST_SUITE_P(
    Terms, PotentialTest,
    testing::Values(
        PotentialCase{"stretching", kStretching, kOneSided, kFlat},
        PotentialCase{"stretching_arc", kStretching, kOneSided, kArc},
        PotentialCase{"stretching_central", kStretching, kCentral, kSphere},
        PotentialCase{"stretching_forward_area", kStretching, kForwardArea, kArc},
        PotentialCase{"variational_forward_area", kVariational, kForwardArea, kSphere},
        PotentialCase{"variational_tube", kVariational, kTube, kCircle},
        PotentialCase{"stretching_tube", kStretching, kTube, kCircle},
        PotentialCase{"stretching_paper", kStretching, kPaper, kFlat},
        PotentialCase{"variational", kVariational, kOneSided, kFlat},
        PotentialCase{"variational_arc", kVariational, kOneSided, kArc},
        PotentialCase{"variational_sphere", kVariational, kOneSided, kSphere},
        PotentialCase{"variational_central", kVariational, kCentral, kArc},
        PotentialCase{"stretching_symmetric", kStretching, kSymmetric, kFlat},
        PotentialCase{"stretching_symmetric_sphere", kStretching, kSymmetric, kSphere},
        PotentialCase{"stretching_symmetric_tube", kStretching, kSymmetricTube, kCircle},
        PotentialCase{"variational_symmetric", kVariational, kSymmetric, kFlat},
        PotentialCase{"variational_symmetric_sphere", kVariational, kSymmetric, kSphere},
        PotentialCase{"variational_symmetric_tube", kVariational, kSymmetricTube, kCircle},
        PotentialCase{"springs", kSprings, kOneSided, kArc}),
    [](const auto& test) { return test.param.name; });

/// With the paper's mixed frame at the border the variational force is not a gradient: the check
/// can fail.
TEST(Potential, VariationalForceIsNoGradientOnAMixedFrame) {
  Simulation s = simulation_from_text(scene(kVariational, kPaper, kArc));
  State state = disturbed(s, 0.1);
  const NodeVectors force = s.system().terms().internal_force(0, state);
  double worst = 0;
  for (Index a = 0; a < force.rows(); ++a) {
    const double h = 1e-5, r = state.r(a, 2);
    state.r(a, 2) = r + h;
    const double above = s.system().terms().energy(0, state);
    state.r(a, 2) = r - h;
    const double below = s.system().terms().energy(0, state);
    state.r(a, 2) = r;
    worst = std::max(worst, std::abs(force(a, 2) + (above - below) / (2 * h)));
  }
  EXPECT_GT(worst, 1e-3 * force.norm());
}

struct RigidCase {
  std::string name, energy, grid, rest;
  friend void PrintTo(const RigidCase& c, std::ostream* out) { *out << c.name; }
};
class RigidMotionTest : public testing::TestWithParam<RigidCase> {};

TEST_P(RigidMotionTest, GivesNoForce) {
  Simulation s = simulation_from_text(scene(GetParam().energy, GetParam().grid, GetParam().rest));
  const double reference = s.system().terms().internal_force(0, disturbed(s, 0.01)).norm();
  State moved{s.system().rest(), NodeVectors::Zero(s.system().nodes(), 3), 0};
  const Eigen::Matrix3d rotation =
      Eigen::AngleAxisd(1.1, Vec3(1, -2, 0.7).normalized()).toRotationMatrix();
  const Eigen::RowVector3d shift(3, -1, 2);
  moved.r = (moved.r * rotation.transpose()).eval().rowwise() + shift;
  const double force = s.system().terms().internal_force(0, moved).norm() / reference;
  EXPECT_LT(force, 1e-9);
  RecordProperty("force_over_that_at_1_percent_strain", scientific(force));
  const double energy_scale = s.system().terms().energy(0, disturbed(s, 0.01));
  EXPECT_LT(s.system().terms().energy(0, moved), 1e-9 * energy_scale);
}

std::vector<RigidCase> rigid_cases() {
  std::vector<RigidCase> cases;
  for (const auto& [rest_name, rest] :
       {std::pair{"flat", kFlat}, {"arc", kArc}, {"sphere", kSphere}})
    for (const auto& [name, energy] :
         {std::pair{"stretching", kStretching},
          {"variational", kVariational},
          {"springs", kSprings},
          {"gauss_divergence", bending(kGauss, "divergence")},
          {"gauss_expanded", bending(kGauss, "expanded")},
          {"exact_divergence", bending(kExact, "divergence")},
          {"terzopoulos_divergence", bending(kTerzopoulos, "divergence")}})
      for (const auto& [grid_name, grid] : {std::pair{"", kOneSided}, {"_symmetric", kSymmetric}})
        cases.push_back({std::string(name) + "_" + rest_name + grid_name, energy, grid, rest});
  return cases;
}
INSTANTIATE_TEST_SUITE_P(Terms, RigidMotionTest, testing::ValuesIn(rigid_cases()),
                         [](const auto& test) { return test.param.name; });

/// Net force and torque of one disturbed state.
Momenta momenta(const std::string& energy, const std::string& grid, const std::string& rest) {
  Simulation s = simulation_from_text(scene(energy, grid, rest));
  const State state = disturbed(s, 0.05);
  return deform::momenta(s.system().terms().internal_force(0, state), state.r);
}

TEST(Momenta, AreThoseOfEachForm) {
  constexpr double kZero = 1e-12, kNot = 1e-6;
  const auto expect = [&](const std::string& name, const std::string& energy,
                          const std::string& grid, const std::string& rest, bool force_free,
                          bool torque_free) {
    const Momenta m = momenta(energy, grid, rest);
    EXPECT_EQ(m.force < kZero, force_free) << name << " Σf " << m.force;
    EXPECT_EQ(m.force > kNot, !force_free) << name << " Σf " << m.force;
    EXPECT_EQ(m.torque < kZero, torque_free) << name << " Σr×f " << m.torque;
    EXPECT_EQ(m.torque > kNot, !torque_free) << name << " Σr×f " << m.torque;
    RecordProperty(name, scientific(m.force) + " " + scientific(m.torque));
  };
  for (const std::string& rest : {kFlat, kArc}) {
    for (const std::string& grid : {kPaper, kOneSided, kCentral, kSymmetric}) {
      expect("expanded gauss", bending(kGauss, "expanded"), grid, rest, false, false);
      expect("divergence gauss", bending(kGauss, "divergence"), grid, rest, true, false);
      expect("divergence exact", bending(kExact, "divergence"), grid, rest, true, false);
      expect("divergence terzopoulos", bending(kTerzopoulos, "divergence"), grid, rest, true, true);
      expect("stretching", kStretching, grid, rest, true, true);
      expect("springs", kSprings, grid, rest, true, true);
    }
    expect("variational", kVariational, kOneSided, rest, true, true);
    expect("variational", kVariational, kCentral, rest, true, true);
    expect("variational", kVariational, kSymmetric, rest, true, true);
  }
  // The torque of a sample is L r × xi (L r − B⁰ n) = −xi B⁰ L r × n: on the mixed frame's border
  // rows L r is not B n, so it is there as soon as B⁰ is.
  expect("variational, mixed frame", kVariational, kPaper, kArc, true, false);
  expect("variational, mixed frame, flat rest", kVariational, kPaper, kFlat, true, true);
}

TEST(LaggedOperator, GivesTheForceAtItsOwnState) {
  for (const std::string& grid : {kPaper, kOneSided, kCentral, kSymmetric})
    for (const std::string& rest : {kFlat, kArc})
      for (const std::string& energy :
           {kStretching, kVariational, kSprings, bending(kGauss, "divergence"),
            bending(kGauss, "expanded"), bending(kExact, "divergence"), bending(kExact, "expanded"),
            bending(kTerzopoulos, "divergence"), bending(kTerzopoulos, "expanded")}) {
        Simulation s = simulation_from_text(scene(energy, grid, rest));
        EXPECT_LT(lagged_error(s.system(), 0, disturbed(s, 0.05)), 1e-11) << energy << grid << rest;
      }
}

TEST(LaggedOperator, IsSymmetricAndSemidefiniteWherePromised) {
  for (const std::string& energy :
       {kStretching, kVariational, kSprings, bending(kTerzopoulos, "divergence")}) {
    Simulation s = simulation_from_text(scene(energy, kPaper, kArc));
    const TermTraits traits = s.system().energies().front().object->traits();
    ASSERT_EQ(traits.lagged, Lagged::symmetric) << energy;
    const SparseMatrix k = s.system().terms().lagged_force(0, disturbed(s, 0.05)).k;
    EXPECT_LT(asymmetry(k), 1e-13) << energy;
    if (traits.semidefinite) {
      EXPECT_LT(indefiniteness(k), 1e-12) << energy;
    }
  }
}

/// Where β varies smoothly both forms are the same expression (22): their difference falls under
/// refinement, whatever the scheme and the weights. At a state that bends, unlike a rigid motion's.
TEST(Expanded, TendsToTheDivergenceFormInside) {
  const auto difference = [](const std::string& grid, int n) {
    const auto force_density = [&](const std::string& form) {
      const std::string size = std::to_string(n);
      const std::string text =
          R"({"surface": {"plugin": "grid", "nodes": [)" + size + ", " + size + "], " + grid +
          R"(}, "energies": [)" + bending(kExact, form) +
          R"(], "integrator": {"plugin": "semi_implicit", "step": 0.01}, "duration": 0.01})";
      Simulation s = simulation_from_text(text);
      State state{s.system().rest(), NodeVectors::Zero(n * n, 3), 0};
      for (Index a = 0; a < state.r.rows(); ++a) {
        const double x = state.r(a, 0), y = state.r(a, 1);
        state.r(a, 2) = 0.1 * std::sin(3 * x + 1) * std::cos(2 * y);
        state.r(a, 0) += 0.05 * std::sin(2 * y);
      }
      const NodeVectors f = s.system().terms().internal_force(0, state);
      NodeVectors inside(0, 3);
      for (Index a = 0; a < f.rows(); ++a) {
        const Vec2 at = s.system().surface().parameters().row(a);
        if ((at - Vec2(.5, .5)).lpNorm<Eigen::Infinity>() > 0.26) continue;
        inside.conservativeResize(inside.rows() + 1, 3);
        inside.row(inside.rows() - 1) = f.row(a) / s.system().surface().areas()[a];
      }
      return inside;
    };
    const NodeVectors expanded = force_density("expanded"),
                      divergence = force_density("divergence");
    return (expanded - divergence).cwiseAbs().maxCoeff() / divergence.cwiseAbs().maxCoeff();
  };
  for (const std::string& grid : {kPaper, kOneSided, kForwardArea})
    EXPECT_NEAR(std::log2(difference(grid, 33) / difference(grid, 65)), 1.0, 0.3) << grid;
  for (const std::string& grid : {kCentral, kSymmetric})
    EXPECT_NEAR(std::log2(difference(grid, 33) / difference(grid, 65)), 2.0, 0.3) << grid;
}

/// A curved strip pressed flat: no bending force under the fallback, which vanishes with B (theory
/// of the delta rule); the exact normal and the variational form push back.
TEST(DeltaFallback, HasNoForceOnAFlattenedCurvedStrip) {
  const auto force = [](const std::string& energy) {
    Simulation s = simulation_from_text(scene(energy, kPaper, kArc));
    State flat{s.system().rest(), NodeVectors::Zero(s.system().nodes(), 3), 0};
    flat.r.leftCols<2>() = s.system().surface().parameters();
    flat.r.col(2).setZero();
    return s.system().terms().internal_force(0, flat).norm();
  };
  EXPECT_EQ(force(bending(R"({"plugin": "gauss", "delta": 0.5})", "divergence")), 0.0);
  EXPECT_GT(force(bending(kExact, "divergence")), 1e-4);
  EXPECT_GT(force(kVariational), 1e-4);
}

}  // namespace
}  // namespace deform
