/// Pressure and wind while a surface moves: terminal velocity, large steps, mirror images, threads.
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <unistd.h>

#include <fmt/format.h>
#include <tbb/global_control.h>

#include "model/support/simulate.h"

namespace deform {
namespace {

using test::run_to_end;
using test::simulation_from_text;

/// A 1 m × 0.8 m sheet of 0.1 kg/m², pinned where `constraints` say so.
Simulation sheet(
    const std::string& forces, const std::string& constraints, double step, double duration,
    const std::string& integrator = "semi_implicit",
    const std::string& surface = R"("plugin": "grid", "nodes": [9, 7], "size": [1, 0.8],
                               "differences": "forward")") {
  return simulation_from_text(fmt::format(
      R"({{"title": "air", "surface": {{{}}},
          "material": {{"density": 0.1}},
          "energies": [{{"plugin": "stretching", "eta": 5}},
                       {{"plugin": "bending_variational", "xi": 0.001}}],
          "forces": [{}], "constraints": [{}],
          "integrator": {{"plugin": "{}", "step": {}}}, "duration": {},
          "limits": {{"distance": 1000}}}})",
      surface, forces, constraints, integrator, step, duration));
}

// A free sheet that a stream pushes is unstable, as every layer is that a lighter one accelerates:
// it crumples. One that can only move along z is not.
constexpr const char* kUpright =
    R"({"plugin": "pin", "where": {"box": [[0, 0], [1, 0.8]]}, "components": ["x", "y"]})";
constexpr const char* kPinned = R"({"plugin": "pin", "where": {"boundary": "left"}})";

Vec3 mean_velocity(const Simulation& s) { return s.state().v.colwise().mean().transpose(); }

/// A flat sheet that falls flatly: m dv/dt = m g − ½ ρ A c_n v², v = v_e tanh(g t/v_e).
TEST(Wind, FallingSheetReachesItsTerminalVelocity) {
  const double end = std::sqrt(2 * 0.1 * 9.81 / (1.2 * 1.0));
  const std::string forces = R"({"plugin": "gravity"}, {"plugin": "wind"})";
  double last_error = 0;
  for (const double step : {0.004, 0.002}) {
    Simulation s = sheet(forces, "", step, 0.1);
    ASSERT_FALSE(run_to_end(s));
    const double error =
        std::abs(mean_velocity(s).z() + end * std::tanh(9.81 * s.state().time / end));
    EXPECT_LT(error, 0.2 * step * 9.81);
    if (last_error != 0) {
      EXPECT_NEAR(last_error / error, 2, 0.2);  // first order
    }
    last_error = error;
  }
  Simulation s = sheet(forces, "", 0.01, 1.5);
  ASSERT_FALSE(run_to_end(s));
  EXPECT_NEAR(mean_velocity(s).z(), -end, 1e-9 * end);
}

/// 0.1 kg/m² of sheet in a storm: mass/(ρ u) is 2 ms. The bounded step never overshoots the wind's
/// velocity, however large; an explicit one does, which shows that the bound is what holds it.
TEST(Wind, DoesNotOvershootInLargeSteps) {
  const std::string storm = R"({"plugin": "wind", "velocity": [0, 0, 40]})";
  Simulation bounded = sheet(storm, kUpright, 0.1, 2);
  double last = 0;
  while (bounded.steps() < bounded.scene().steps()) {
    bounded.step();
    const double w = mean_velocity(bounded).z();
    EXPECT_GT(w, last);
    EXPECT_LT(w, 40);
    last = w;
  }
  EXPECT_GT(last, 39);
  Simulation explicit_step = sheet(storm, kUpright, 0.1, 2, "symplectic_euler");
  explicit_step.step();
  EXPECT_GT(mean_velocity(explicit_step).z(), 40);
}

/// A flag that is held at one side, in air at rest after a start at 3 m/s: with neither wind nor
/// gravity, its energy only falls.
TEST(Wind, StillAirTakesEnergyOfAMovingSheet) {
  Simulation s = simulation_from_text(
      R"({"title": "air", "surface": {"plugin": "grid", "nodes": [9, 7], "size": [1, 0.8],
                                         "differences": "forward"},
          "material": {"density": 0.1}, "energies": [{"plugin": "stretching", "eta": 5}],
          "forces": [{"plugin": "wind"}], "velocity": [0.5, 0.2, 3],
          "constraints": [{"plugin": "pin", "where": {"boundary": "left"}}],
          "integrator": {"plugin": "symplectic_euler", "step": 1e-4}, "duration": 0.5})");
  const auto energy = [&s] {
    const NodeValues speed = s.state().v.rowwise().squaredNorm();
    return 0.5 * s.system().mass().dot(speed) + s.system().terms().energy(0, s.state());
  };
  s.step();
  const double begin = energy();
  double last = begin;
  while (s.steps() < s.scene().steps()) {
    for (int i = 0; i < 100; ++i) s.step();
    EXPECT_LT(energy(), last * (1 + 1e-3));  // the integrator's own energy swings by its step
    last = energy();
  }
  EXPECT_LT(last, 0.5 * begin);
}

/// In the mirrored world n is turned round, and so is the push: it is the whole world that is
/// reflected. A pressure that kept its direction there would part from the image at once.
TEST(Air, MirrorImageOfARunIsTheRunOfTheImage) {
  for (const char* force : {R"({"plugin": "pressure", "pressure": 2, "time": {"ramp": [0, 0.2]}})",
                            R"({"plugin": "wind", "velocity": [3, 1, -5]})",
                            R"({"plugin": "gravity"}, {"plugin": "wind", "velocity": [3, 1, 5]},
           {"plugin": "pressure", "pressure": -1})"}) {
    Simulation s = sheet(force, kPinned, 0.005, 0.3);
    const auto image = s.mirrored();
    while (s.steps() < s.scene().steps()) {
      s.step();
      image->step();
    }
    EXPECT_GT(s.state().r.col(2).cwiseAbs().maxCoeff(), 0.05) << force;
    NodeVectors reflected = image->state().r;
    reflected.col(2) *= -1;
    EXPECT_LE((s.state().r - reflected).rowwise().norm().maxCoeff(), 1e-12) << force;
  }
}

/// Upwards is where n of a flat sheet points: the sheet rises, its image sinks.
TEST(Air, PressurePushesAlongTheNormalInBothWorlds) {
  Simulation s = sheet(R"({"plugin": "pressure", "pressure": 2})", "", 0.005, 0.1);
  const auto image = s.mirrored();
  s.step();
  image->step();
  EXPECT_NEAR(mean_velocity(s).z(), 0.005 * 2 / 0.1, 1e-12);
  EXPECT_NEAR(image->state().v.col(2).mean(), -0.005 * 2 / 0.1, 1e-12);
}

TEST(Air, SameBitsAtAnyNumberOfThreads) {
  NodeVectors one;
  for (const std::size_t threads : {1, 2, 4}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    Simulation s =
        sheet(R"({"plugin": "wind", "velocity": [3, 1, 5]}, {"plugin": "pressure", "pressure": 1})",
              kPinned, 0.005, 0.2, "semi_implicit",
              R"("plugin": "grid", "nodes": [25, 21], "size": [1, 0.8],
                 "differences": "forward")");
    ASSERT_FALSE(run_to_end(s));
    if (threads == 1) one = s.state().r;
    EXPECT_EQ(std::memcmp(one.data(), s.state().r.data(),
                          static_cast<std::size_t>(one.size()) * sizeof(double)),
              0)
        << threads << " threads";
  }
}

/// A file of a torus whose sides are both joined: the grid's faces then have no boundary.
class Torus {
 public:
  static constexpr int kAround = 16, kAcross = 8;
  static constexpr double kRing = 1, kTube = 0.4;

  Torus()
      : file_(std::filesystem::temp_directory_path() / fmt::format("torus_{}.txt", ::getpid())) {
    std::ofstream out(file_);
    for (int j = 0; j < kAcross; ++j)
      for (int i = 0; i < kAround; ++i) {
        const double u = 2 * std::numbers::pi * i / kAround, v = 2 * std::numbers::pi * j / kAcross;
        const double ring = kRing + kTube * std::cos(v);
        out << fmt::format("{:.17g} {:.17g} {:.17g}\n", ring * std::cos(u), ring * std::sin(u),
                           kTube * std::sin(v));
      }
  }
  ~Torus() { std::filesystem::remove(file_); }
  Torus(const Torus&) = delete;
  Torus& operator=(const Torus&) = delete;

  [[nodiscard]] std::string surface() const {
    return fmt::format(
        R"("plugin": "grid", "nodes": [{}, {}], "size": [{}, {}], "differences": "forward",
            "periodic": [true, true],
           "rest": {{"plugin": "file", "path": "{}"}})",
        kAround, kAcross, 2 * std::numbers::pi * kRing, 2 * std::numbers::pi * kTube,
        file_.string());
  }
  /// That of the polyhedron's trapezoids: a regular polygon of the tube's, turned about the axis by
  /// prismatoids.
  [[nodiscard]] static double volume() {
    const double sine = std::sin(2 * std::numbers::pi / kAround) / 2;
    double sum = 0;
    for (int j = 0; j < kAcross; ++j) {
      const double v = 2 * std::numbers::pi * j / kAcross,
                   w = 2 * std::numbers::pi * (j + 1) / kAcross;
      const double a = kRing + kTube * std::cos(v), b = kRing + kTube * std::cos(w);
      const double height = kTube * (std::sin(w) - std::sin(v));
      sum += kAround * sine * height * (a * a + a * b + b * b) / 3;  // a frustum, signed
    }
    return sum;
  }

 private:
  std::filesystem::path file_;
};

TEST(Pressure, OnATorusSumsToZeroAndHasItsVolumeAsPotential) {
  const Torus torus;
  Simulation s = sheet(R"({"plugin": "pressure", "pressure": 5})", "", 0.001, 0.2, "semi_implicit",
                       torus.surface());
  EXPECT_NEAR(s.system().terms().external_potential(s.state()), -5 * Torus::volume(),
              1e-12 * 5 * Torus::volume());
  const auto net = [&s] {
    return s.system().terms().external_force(s.state()).colwise().sum().norm();
  };
  EXPECT_LT(net(), 1e-12);
  const double at_first = s.system().terms().external_potential(s.state());
  ASSERT_FALSE(run_to_end(s));
  EXPECT_LT(net(), 1e-12);
  EXPECT_LT(s.system().terms().external_potential(s.state()), at_first);  // it has swollen
  const NodeValues& mass = s.system().mass();
  EXPECT_LT((mass.transpose() * s.state().r).norm(), 1e-9 * mass.sum());  // in its place
}

/// What the pressure puts in is what the surface gets: kinetic energy, stretching and −p V.
TEST(Pressure, KeepsTheEnergyOfAClosedSurface) {
  const Torus torus;
  double last_drift = 0;
  for (const double step : {2e-4, 1e-4}) {
    Simulation s = sheet(R"({"plugin": "pressure", "pressure": 5})", "", step, 0.1,
                         "symplectic_euler", torus.surface());
    const auto energy = [&s] {
      double sum = 0.5 * s.system().mass().dot(s.state().v.rowwise().squaredNorm());
      for (std::size_t t = 0; t < s.system().energies().size(); ++t)
        sum += s.system().terms().energy(t, s.state());
      return sum + s.system().terms().external_potential(s.state());
    };
    const double begin = energy();
    double drift = 0, kinetic = 0;
    while (s.steps() < s.scene().steps()) {
      s.step();
      drift = std::max(drift, std::abs(energy() - begin));
      kinetic = std::max(kinetic, 0.5 * s.system().mass().dot(s.state().v.rowwise().squaredNorm()));
    }
    EXPECT_LT(drift, 0.02 * kinetic);
    if (last_drift != 0) {
      EXPECT_NEAR(last_drift / drift, 2, 0.2);  // the integrator's first order
    }
    last_drift = drift;
  }
}

}  // namespace
}  // namespace deform
