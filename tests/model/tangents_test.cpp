/// Tangents of every energy with a potential against finite differences of its force, and what the
/// semidefinite ones promise.
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

constexpr const char* kOneSided =
    R"("differences": "forward", "border": "one_sided", "weights": "equal")";
constexpr const char* kCentral =
    R"("differences": "central", "border": "one_sided", "weights": "area")";
constexpr const char* kFlat = R"({"plugin": "flat"})";
constexpr const char* kSphere = R"({"plugin": "sphere_patch", "radius": 1.5})";
constexpr const char* kStretching =
    R"({"plugin": "stretching", "eta": [[0.02, 0.005], [0.005, 0.01]]})";
constexpr const char* kVariational =
    R"({"plugin": "bending_variational", "xi": [[2e-4, 1e-4], [1e-4, 3e-4]]})";
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

INSTANTIATE_TEST_SUITE_P(All, Tangents,
                         testing::Values(Case{"stretching_flat", kStretching, kOneSided, kFlat},
                                         Case{"stretching_sphere", kStretching, kCentral, kSphere},
                                         Case{"bending_flat", kVariational, kCentral, kFlat},
                                         Case{"bending_forward", kVariational, kOneSided, kFlat},
                                         Case{"bending_sphere", kVariational, kCentral, kSphere},
                                         Case{"springs", kSprings, kCentral, kSphere}),
                         [](const auto& tested) { return std::string(tested.param.name); });

}  // namespace
}  // namespace deform
