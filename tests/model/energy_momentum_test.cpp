/// implicit_midpoint with strains averaged over the step: energy and momenta are kept, whatever the
/// step and the stiffness.
#include <cmath>
#include <random>
#include <string>
#include <tuple>
#include <vector>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "model/support/simulate.h"

namespace deform {
namespace {

using test::run_to_end;
using test::simulation_from_text;

constexpr const char* kKoiter =
    R"({"plugin": "koiter", "young": 1e6, "poisson": 0.3, "thickness": 0.02})";
constexpr const char* kOrthotropic =
    R"({"plugin": "koiter_orthotropic", "young_1": 2e6, "young_2": 1e6, "poisson": 0.2,
        "shear": 4e5, "thickness": 0.02})";
constexpr const char* kPaper =
    R"({"plugin": "stretching", "eta": 50}, {"plugin": "bending_variational", "xi": 0.1})";
constexpr const char* kSprings = R"({"plugin": "edge_springs", "stiffness": 300})";

std::string scene(const std::string& energies, const std::string& rest = "flat") {
  return fmt::format(R"({{"surface": {{"plugin": "grid", "nodes": [6, 5], "size": [1.0, 0.8],
      "differences": "symmetric", "border": "one_sided", "weights": "area",
      "rest": {{"plugin": {}}}}},
    "material": {{"density": 0.4}}, "energies": [{}],
    "integrator": {{"plugin": "implicit_midpoint", "step": 0.01}}, "duration": 1}})",
                     rest == "flat" ? R"("flat")" : rest, energies);
}

/// Positions of a surface that is turned by an angle about some axis, moved, and deformed.
NodeVectors moved(const NodeVectors& rest, double angle, double deformation, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> number(-1, 1);
  const Vec3 axis = Vec3(number(random), number(random), number(random)).normalized();
  const Vec3 shift(number(random), number(random), number(random));
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(angle, axis).toRotationMatrix();
  NodeVectors r = rest * turn.transpose();
  r.rowwise() += shift.transpose();
  for (Index i = 0; i < r.size(); ++i) r.data()[i] += deformation * number(random);
  return r;
}

double internal_energy(const System& system, const State& state) {
  double sum = 0;
  for (std::size_t t = 0; t < system.energies().size(); ++t) sum += system.terms().energy(t, state);
  return sum;
}

class OverAStep : public testing::TestWithParam<std::tuple<std::string, std::string>> {};

/// The force of the mean strains does the work of the change of energy, and has neither a resultant
/// nor a moment about anything, for steps of any size: each to rounding.
TEST_P(OverAStep, ForcesOfMeanStrainsConserve) {
  Simulation s = simulation_from_text(std::get<1>(GetParam()));
  System& system = s.system();
  for (const double angle : {0.0, 0.1, 1.5})
    for (const double deformation : {0.0, 1e-3, 0.02}) {
      State start = s.state(), end = s.state();
      start.r = moved(system.rest(), 0.3, deformation, 1);
      end.r = moved(start.r, angle, deformation, 2);
      const double change = internal_energy(system, end) - internal_energy(system, start);
      const double scale = internal_energy(system, end) + internal_energy(system, start);
      State middle = start;
      middle.r = 0.5 * (start.r + end.r);
      StepStrains strains;
      strains.average_from(system.evaluator(), start.r);
      const NodeVectors f = system.evaluator().force(middle, &strains);
      const double forces = f.rowwise().norm().sum() + 1e-9;
      EXPECT_NEAR(f.cwiseProduct(end.r - start.r).sum(), -change, 1e-10 * (scale + forces));
      EXPECT_LT(f.colwise().sum().norm(), 1e-12 * forces);
      Vec3 moment = Vec3::Zero();
      for (Index a = 0; a < f.rows(); ++a) moment += Vec3(middle.r.row(a)).cross(Vec3(f.row(a)));
      EXPECT_LT(moment.norm(), 1e-11 * forces) << angle << ' ' << deformation;
    }
}

/// Without a step they are the forces of the state, and close to one they differ by the square.
TEST_P(OverAStep, ForcesOfMeanStrainsAreOfSecondOrder) {
  Simulation s = simulation_from_text(std::get<1>(GetParam()));
  System& system = s.system();
  State state = s.state();
  state.r = moved(system.rest(), 0.3, 0.01, 1);
  const NodeVectors exact = system.evaluator().force(state);
  const NodeVectors way = moved(state.r, 0.2, 0.01, 2) - state.r;
  const auto error = [&](double h) {
    const NodeVectors start = state.r - 0.5 * h * way;
    StepStrains strains;
    strains.average_from(system.evaluator(), start);
    return (system.evaluator().force(state, &strains) - exact).norm() / exact.norm();
  };
  EXPECT_LT(error(0), 1e-12);
  const double coarse = error(0.02), fine = error(0.01);
  EXPECT_NEAR(std::log2(coarse / fine), 2, 0.05) << coarse << ' ' << fine;
}

/// What searches go by: the energy of the mean strains falls by the work of the forces that are
/// its gradient, which is what is left when the others are taken away.
TEST_P(OverAStep, NonconservativeForcesAreTheRest) {
  Simulation s = simulation_from_text(std::get<1>(GetParam()));
  System& system = s.system();
  State state = s.state();
  const NodeVectors start = moved(system.rest(), 0.3, 0.01, 1);
  state.r = 0.5 * (start + moved(start, 0.4, 0.01, 2));
  const NodeVectors way = moved(state.r, 0.1, 0.05, 3) - state.r;
  StepStrains strains;
  strains.average_from(system.evaluator(), start);
  const NodeVectors f = system.evaluator().force(state, &strains) -
                        system.evaluator().nonconservative_force(state, &strains);
  const double h = 1e-5;
  State there = state;
  there.r = state.r + h * way;
  const double ahead = system.evaluator().potential(there, &strains);
  there.r = state.r - h * way;
  const double behind = system.evaluator().potential(there, &strains);
  const double slope = (ahead - behind) / (2 * h);
  EXPECT_NEAR(slope, -f.cwiseProduct(way).sum(), 1e-6 * std::abs(slope));
}

INSTANTIATE_TEST_SUITE_P(
    Energies, OverAStep,
    testing::Values(std::tuple{"koiter", scene(kKoiter)},
                    std::tuple{"koiter_torus",
                               scene(kKoiter, R"("torus", "radius": 1, "tube": 0.4)")},
                    std::tuple{"koiter_orthotropic", scene(kOrthotropic)},
                    std::tuple{"stretching_and_bending", scene(kPaper)},
                    std::tuple{"edge_springs", scene(kSprings)},
                    std::tuple{"all", scene(fmt::format("{}, {}, {}", kKoiter, kPaper, kSprings))}),
    [](const auto& each) { return std::get<0>(each.param); });

Vec3 angular_momentum(const System& system, const State& state) {
  Vec3 sum = Vec3::Zero();
  for (Index a = 0; a < state.r.rows(); ++a)
    sum += system.mass()[a] * Vec3(state.r.row(a)).cross(Vec3(state.v.row(a)));
  return sum;
}

double energy(const System& system, const State& state) {
  return internal_energy(system, state) + 0.5 * system.mass().dot(state.v.rowwise().squaredNorm());
}

class FreeMotion : public testing::TestWithParam<std::tuple<std::string, std::string, double>> {};

/// Both to what the tolerance of Newton's method leaves over 1000 steps.
TEST_P(FreeMotion, KeepsEnergyAndAngularMomentum) {
  const auto& [name, more, step] = GetParam();
  Simulation s = simulation_from_text(
      fmt::format(R"({{"surface": {{"plugin": "grid", "nodes": [5, 5], "size": [1, 1]}},
        "material": {{"density": 0.2}}, "limits": {{"distance": 1e6}}, {},
        "integrator": {{"plugin": "implicit_midpoint", "step": {}}}, "duration": {}}})",
                  more, step, 1000 * step));
  const double first = energy(s.system(), s.state());
  const Vec3 l = angular_momentum(s.system(), s.state());
  double worst = 0, worst_l = 0;
  while (s.steps() < s.scene().steps()) {
    s.step();
    worst = std::max(worst, std::abs(energy(s.system(), s.state()) - first) / first);
    worst_l = std::max(worst_l, (angular_momentum(s.system(), s.state()) - l).norm() / l.norm());
  }
  EXPECT_LT(worst, 1e-6);
  EXPECT_LT(worst_l, 1e-6);
  RecordProperty("energy", fmt::format("{:.2g}", worst));
  RecordProperty("angular_momentum", fmt::format("{:.2g}", worst_l));
}

constexpr const char* kStiff =
    R"("energies": [{"plugin": "koiter", "young": 1e6, "poisson": 0.3, "thickness": 1e-3}],
       "velocity": {"spin": [0, 0, 2]})";
/// Turns about no axis of symmetry, bent at first.
constexpr const char* kBent =
    R"s("energies": [{"plugin": "koiter", "young": 1e5, "poisson": 0.3, "thickness": 1e-2}],
       "velocity": ["1 + 2*(a2-0.5)", "-2*(a1-0.5)", "3*(a1-0.5)^2 + a2"])s";
constexpr const char* kOfSprings =
    R"("energies": [{"plugin": "edge_springs", "stiffness": 1000}],
       "velocity": {"spin": [0.3, 0, 2]})";

INSTANTIATE_TEST_SUITE_P(
    Scenes, FreeMotion,
    testing::Values(std::tuple{"spin", kStiff, 0.001}, std::tuple{"spin", kStiff, 0.01},
                    std::tuple{"spin", kStiff, 0.1}, std::tuple{"bent", kBent, 0.001},
                    std::tuple{"bent", kBent, 0.01}, std::tuple{"bent", kBent, 0.1},
                    std::tuple{"springs", kOfSprings, 0.001},
                    std::tuple{"springs", kOfSprings, 0.01},
                    std::tuple{"springs", kOfSprings, 0.1}),
    [](const auto& each) {
      return fmt::format("{}_{}us", std::get<0>(each.param),
                         std::lround(1e6 * std::get<2>(each.param)));
    });

}  // namespace
}  // namespace deform
