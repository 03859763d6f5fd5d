/// Tangents of every energy with a potential against finite differences of its force, and what the
/// semidefinite ones promise.
#include <cmath>
#include <ostream>

#include "deform/check/mechanics.h"

#include "model/support/simulate.h"

namespace deform {
namespace {

using test::simulation_from_text;

constexpr double kStrain = 0.05;

struct Case {
  const char* name;
  const char* energy;
  const char* grid;
  const char* rest;
};

void PrintTo(const Case& tested, std::ostream* out) { *out << tested.name; }

constexpr const char* kOneSided =
    R"("differences": "forward", "border": "one_sided", "weights": "equal")";
constexpr const char* kCentral =
    R"("differences": "central", "border": "one_sided", "weights": "area")";
constexpr const char* kSymmetric =
    R"("differences": "symmetric", "border": "one_sided", "weights": "area")";
constexpr const char* kSheared =
    R"json({"plugin": "formula", "x": "a1+0.3*a2", "y": "0.8*a2+0.1*a1^2", "z": "0.2*sin(3*a1*a2)"
})json";
constexpr const char* kTorusPart =
    R"json({"plugin": "formula", "x": "(1+0.4*cos(2*a2))*cos(a1)", "y": "(1+0.4*cos(2*a2))*sin(a1)",
        "z": "0.4*sin(2*a2)"
})json";
constexpr const char* kFlat = R"({"plugin": "flat"})";
constexpr const char* kSphere = R"({"plugin": "sphere_patch", "radius": 1.5})";
constexpr const char* kStretching =
    R"({"plugin": "stretching", "eta": [[0.02, 0.005], [0.005, 0.01]]})";
constexpr const char* kVariational =
    R"({"plugin": "bending_variational", "xi": [[2e-4, 1e-4], [1e-4, 3e-4]]})";
constexpr const char* kKoiter =
    R"({"plugin": "koiter", "young": 50, "poisson": 0.3, "thickness": 0.05})";
constexpr const char* kOrthotropic =
    R"({"plugin": "koiter_orthotropic", "young_1": 60, "young_2": 30, "shear": 9, "poisson": 0.4,
        "thickness": 0.05})";
constexpr const char* kIsotropic =
    R"({"plugin": "koiter_orthotropic", "young_1": 50, "young_2": 50, "shear": 19.23076923076923,
        "poisson": 0.3, "thickness": 0.05})";
constexpr const char* kThinPlate = R"({"plugin": "thin_plate", "xi": 2e-4, "poisson": 0.3})";
constexpr const char* kIsometric =
    R"({"plugin": "koiter", "young": 50, "poisson": 0.3, "thickness": 0.05,
        "bending": "isometric"})";
constexpr const char* kOrthotropicIsometric =
    R"({"plugin": "koiter_orthotropic", "young_1": 60, "young_2": 30, "shear": 9, "poisson": 0.4,
        "thickness": 0.05, "bending": "isometric"})";
constexpr const char* kSprings = R"({"plugin": "edge_springs", "stiffness": 2.0})";

class Tangents : public testing::TestWithParam<Case> {
 protected:
  static Simulation simulation() {
    const Case& c = GetParam();
    return simulation_from_text(
        std::string(R"({"surface": {"plugin": "grid", "nodes": [6, 5], "size": [1.0, 0.8], )") +
        c.grid + R"(, "rest": )" + c.rest + R"(}, "material": {"density": 0.1}, "energies": [)" +
        c.energy + R"(], "integrator": {"plugin": "semi_implicit", "step": 0.01},)" +
        R"("duration": 0.01})");
  }
};

TEST_P(Tangents, ExactIsTheDerivativeOfTheForce) {
  Simulation s = simulation();
  EXPECT_LT(tangent_error(s.system(), disturbed(s.system().rest(), kStrain)), 1e-8);
}

TEST_P(Tangents, SemidefiniteOnesAre) {
  Simulation s = simulation();
  const State state = disturbed(s.system().rest(), 3 * kStrain);
  for (const Tangent kind : {Tangent::projected, Tangent::gauss_newton})
    EXPECT_LT(tangent_indefiniteness(s.system(), state, kind), 1e-12);
}

Simulation simulation_of_energies(const std::string& energies, const char* rest,
                                  const std::string& nodes = "[6, 5]") {
  return simulation_from_text(
      R"({"surface": {"plugin": "grid", "nodes": )" + nodes + R"(, "size": [1.0, 0.8], )" +
      kSymmetric + R"(, "rest": )" + rest + R"(}, "material": {"density": 0.1}, "energies": [)" +
      energies +
      R"(], "integrator": {"plugin": "semi_implicit", "step": 0.01}, "duration": 0.01})");
}

/// Two implementations of one energy: the same energy and force at a disturbed state.
void expect_same(const std::string& one, const std::string& other, const char* rest) {
  Simulation a = simulation_of_energies(one, rest), b = simulation_of_energies(other, rest);
  const State state = disturbed(a.system().rest(), kStrain);
  const NodeVectors of_a = a.system().evaluator().force(state),
                    of_b = b.system().evaluator().force(state);
  EXPECT_LT((of_a - of_b).norm(), 1e-12 * of_a.norm());
  EXPECT_NEAR(a.system().evaluator().potential(state) / b.system().evaluator().potential(state), 1,
              1e-12);
}

TEST(Koiter, IsStretchingAndBendingWithoutPoisson) {
  expect_same(R"({"plugin": "koiter", "young": 50, "poisson": 0, "thickness": 0.06})",
              R"({"plugin": "stretching", "eta": 1.5},
                 {"plugin": "bending_variational", "xi": 9e-4})",
              kFlat);
}
TEST(Koiter, IsTheOrthotropicOneWithEqualDirections) {
  for (const char* rest : {kFlat, kSphere, kSheared, kTorusPart})
    expect_same(kKoiter, kIsotropic, rest);
}

/// The energy of a deformation is that of the same one under other parameters: the rest metric is
/// part of it. A square stretched by 1.2 along x and sheared, described by sheared parameters.
TEST(Koiter, KnowsNoParameters) {
  const auto energy = [](const char* rest) {
    Simulation s = simulation_of_energies(kKoiter, rest);
    NodeVectors r = s.system().rest();
    r.col(0) = 1.2 * r.col(0) + 0.1 * r.col(1);
    return s.system().evaluator().potential({r, NodeVectors::Zero(r.rows(), 3), 0});
  };
  const double plain = energy(R"({"plugin": "formula", "x": "a1", "y": "a2"})");
  const double sheared = energy(R"({"plugin": "formula", "x": "2*a1+a2", "y": "0.5*a2"})");
  EXPECT_NEAR(sheared / plain, 1, 1e-12);  // 2 · 0.5: the same rest area
}

/// A flat sheet rolled to radius R has the bending energy ½ D/R² an area: to second order in the
/// spacing.
TEST(Koiter, RolledSheetHasItsEnergy) {
  constexpr double kRadius = 0.5, kArea = 0.8;
  const double D = 50 * 0.05 * 0.05 * 0.05 / (12 * (1 - 0.3 * 0.3));
  const auto error = [&](const char* nodes) {
    const auto sheet = [&](const char* rest) {
      return simulation_of_energies(kKoiter, rest, nodes);
    };
    Simulation flat = sheet(kFlat);
    const Simulation rolled = sheet(R"({"plugin": "arc", "radius": 0.5})");
    const NodeVectors& r = rolled.state().r;
    const double energy = flat.system().terms().energy(1, {r, NodeVectors::Zero(r.rows(), 3), 0});
    return energy / (0.5 * D / (kRadius * kRadius) * kArea) - 1;
  };
  const double coarse = error("[17, 5]"), fine = error("[33, 5]");
  EXPECT_LT(std::abs(fine), 2.5e-3);
  EXPECT_GT(std::log2(coarse / fine), 1.9);
}

/// Where a flat sheet is rolled up without stretching, r_;ij = B_ij n, but for the differences'
/// error, which is of second order; and turning the sheet changes nothing.
TEST(Isometric, IsBendingInTheCurvatureWhereNothingStretches) {
  const auto energies = [&](const char* nodes) {
    const auto of = [&](const char* energy, const char* rest) {
      return simulation_of_energies(energy, rest, nodes);
    };
    Simulation curvature = of(kOrthotropic, kFlat), isometric = of(kOrthotropicIsometric, kFlat);
    const Simulation rolled = of(kOrthotropic, R"({"plugin": "arc", "radius": 0.5})");
    const NodeVectors& r = rolled.state().r;
    const auto bending = [](Simulation& s, const NodeVectors& at) {
      return s.system().terms().energy(1, {at, NodeVectors::Zero(at.rows(), 3), 0});
    };
    const Eigen::Matrix3d turn =
        Eigen::AngleAxisd(2.0, Vec3(1, -2, 0.5).normalized()).toRotationMatrix();
    const double one = bending(isometric, r);
    EXPECT_NEAR(bending(isometric, r * turn.transpose()) / one, 1, 1e-12);
    return one / bending(curvature, r) - 1;
  };
  const double coarse = energies("[17, 5]"), fine = energies("[33, 5]");
  EXPECT_LT(std::abs(fine), 5e-3);
  EXPECT_GT(std::log2(coarse / fine), 1.9);
}

/// Half of a crease across which r_1 vanishes: there the normal, and with it the force of bending
/// in B, is no function of positions; that of the isometric form has a derivative.
TEST(Isometric, HasAForceWhereANodeFrameVanishes) {
  Simulation s = simulation_of_energies(kIsometric, kFlat);
  NodeVectors r = s.system().rest();
  for (Index j = 0; j < 5; ++j) {  // folded back about the third column
    const Index fold = 6 * j + 2;
    r.row(fold + 1) = r.row(fold - 1);
    r(fold, 2) += 0.2;
  }
  const State state{r, NodeVectors::Zero(r.rows(), 3), 0};
  EXPECT_LT(tangent_error(s.system(), state), 1e-8);
}

TEST(Isometric, WantsAFlatRestSurface) {
  for (const char* energy : {kIsometric, kOrthotropicIsometric}) try {
      static_cast<void>(simulation_of_energies(energy, kSphere));
      ADD_FAILURE() << energy;
    } catch (const InputError& e) {
      EXPECT_NE(std::string(e.what()).find("the rest surface is curved"), std::string::npos)
          << e.what();
    }
}

INSTANTIATE_TEST_SUITE_P(
    All, Tangents,
    testing::Values(Case{"stretching_flat", kStretching, kOneSided, kFlat},
                    Case{"stretching_sphere", kStretching, kCentral, kSphere},
                    Case{"bending_flat", kVariational, kCentral, kFlat},
                    Case{"bending_forward", kVariational, kOneSided, kFlat},
                    Case{"bending_sphere", kVariational, kCentral, kSphere},
                    Case{"koiter_flat", kKoiter, kSymmetric, kFlat},
                    Case{"koiter_sphere", kKoiter, kSymmetric, kSphere},
                    Case{"koiter_sheared", kKoiter, kSymmetric, kSheared},
                    Case{"koiter_torus", kKoiter, kSymmetric, kTorusPart},
                    Case{"koiter_central", kKoiter, kCentral, kTorusPart},
                    Case{"orthotropic_sheared", kOrthotropic, kSymmetric, kSheared},
                    Case{"orthotropic_torus", kOrthotropic, kSymmetric, kTorusPart},
                    Case{"thin_plate", kThinPlate, kSymmetric, kFlat},
                    Case{"thin_plate_sphere", kThinPlate, kSymmetric, kSphere},
                    Case{"thin_plate_sheared", kThinPlate, kSymmetric, kSheared},
                    Case{"isometric", kIsometric, kSymmetric, kFlat},
                    Case{"isometric_forward", kIsometric, kOneSided, kFlat},
                    Case{"orthotropic_isometric", kOrthotropicIsometric, kSymmetric, kFlat},
                    Case{"springs", kSprings, kCentral, kSphere}),
    [](const auto& tested) { return std::string(tested.param.name); });

}  // namespace
}  // namespace deform
