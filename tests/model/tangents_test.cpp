/// Tangents of every energy with a potential against finite differences of its force, and what the
/// semidefinite ones promise.
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
                                         Case{"koiter_flat", kKoiter, kSymmetric, kFlat},
                                         Case{"koiter_sphere", kKoiter, kSymmetric, kSphere},
                                         Case{"koiter_sheared", kKoiter, kSymmetric, kSheared},
                                         Case{"koiter_torus", kKoiter, kSymmetric, kTorusPart},
                                         Case{"koiter_central", kKoiter, kCentral, kTorusPart},
                                         Case{"springs", kSprings, kCentral, kSphere}),
                         [](const auto& tested) { return std::string(tested.param.name); });

}  // namespace
}  // namespace deform
