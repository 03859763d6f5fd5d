/// Contact: known distances, Coulomb's law on a slope, and that nothing gets inside.
#include <cmath>
#include <numbers>
#include <random>

#include <fmt/format.h>

#include "deform/model/collider.h"

#include "model/support/simulate.h"

namespace deform {
namespace {

using test::built_in;
using test::simulation_from_text;

std::shared_ptr<Collider> make(const std::string& name,
                               std::initializer_list<std::pair<std::string, ParameterValue>> list) {
  ParameterValues values;
  for (const auto& [key, value] : list) values.set(key, value);
  return built_in()->create<Collider>(
      {PluginKind::collider, name, std::make_shared<const ParameterValues>(values), ""},
      Setup(nullptr));
}

SignedDistance measure(const Collider& collider, const Vec3& point) {
  SignedDistance d;
  const NodeVectors points = point.transpose();
  NodeVectors normal(1, 3);
  collider.measure(0, rows_from(points, 0), {&d.distance, 1}, rows_from(normal, 0));
  d.normal = normal.row(0).transpose();
  return d;
}

TEST(Colliders, MeasureKnownDistances) {
  const auto box = make("box", {{"centre", Vec3(0, 0, 0)}, {"size", Vec3(2, 4, 6)}});
  EXPECT_DOUBLE_EQ(measure(*box, {3, 0, 0}).distance, 2);
  EXPECT_DOUBLE_EQ(measure(*box, {0.5, 0, 0}).distance, -0.5);
  EXPECT_DOUBLE_EQ(measure(*box, {4, 6, 0}).distance, 5);  // at an edge
  EXPECT_TRUE(measure(*box, {-0.5, 0, 0}).normal.isApprox(-Vec3::UnitX()));
  const auto rounded =
      make("box", {{"centre", Vec3(0, 0, 0)}, {"size", Vec3(2, 4, 6)}, {"rounding", 0.5}});
  EXPECT_DOUBLE_EQ(measure(*rounded, {3, 0, 0}).distance, 2);
  EXPECT_DOUBLE_EQ(measure(*rounded, {1, 2, 0}).distance, 0.5 * (std::numbers::sqrt2 - 1));
  const auto cylinder =
      make("cylinder",
           {{"centre", Vec3(1, 0, 0)}, {"axis", Vec3(0, 2, 0)}, {"radius", 1.0}, {"height", 4.0}});
  EXPECT_DOUBLE_EQ(measure(*cylinder, {1, 0, 3}).distance, 2);
  EXPECT_DOUBLE_EQ(measure(*cylinder, {1, 3, 0}).distance, 1);
  EXPECT_DOUBLE_EQ(measure(*cylinder, {1, 6, 4}).distance, 5);
  const auto sphere = make("sphere", {{"centre", Vec3(0, 0, 1)}, {"radius", 2.0}});
  EXPECT_DOUBLE_EQ(measure(*sphere, {0, 0, 1}).distance, -2);
  EXPECT_DOUBLE_EQ(measure(*sphere, {3, 4, 1}).distance, 3);
  const auto plane = make("plane", {{"point", Vec3(0, 0, 1)}, {"normal", Vec3(0, 3, 4)}});
  EXPECT_DOUBLE_EQ(measure(*plane, {7, 5, 1}).distance, 3);
}

/// By looking for the nearest of many points on the surface of the body.
TEST(Colliders, RoundedCylinderAgreesWithPointsOnItsSurface) {
  const double radius = 1, half = 0.5, rounding = 0.2;
  const auto cylinder = make("cylinder", {{"centre", Vec3(0, 0, 0)},
                                          {"radius", radius},
                                          {"height", 2 * half},
                                          {"rounding", rounding}});
  std::vector<Vec2> profile;  // (from axis, along)
  const int n = 4000;
  for (int i = 0; i <= n; ++i) {
    const double t = static_cast<double>(i) / n, angle = t * std::numbers::pi / 2;
    profile.emplace_back(t * (radius - rounding), half);
    profile.emplace_back(radius, (2 * t - 1) * (half - rounding));
    for (const double side : {-1.0, 1.0})
      profile.emplace_back(radius - rounding + rounding * std::sin(angle),
                           side * (half - rounding + rounding * std::cos(angle)));
    profile.emplace_back(t * (radius - rounding), -half);
  }
  std::mt19937 random(3);
  std::uniform_real_distribution<double> anywhere(-2, 2);
  for (int trial = 0; trial < 200; ++trial) {
    const Vec3 p(anywhere(random), anywhere(random), anywhere(random));
    const Vec2 q(p.head<2>().norm(), p.z());
    double least = kInfinity;
    for (const Vec2& s : profile) least = std::min(least, (q - s).norm());
    EXPECT_NEAR(std::abs(measure(*cylinder, p).distance), least, 1e-3);
  }
}

/// A sheet on a plane, gravity tilted by an angle: what a slope is, seen along it.
std::string on_a_slope(double degrees, double friction) {
  const double angle = degrees * std::numbers::pi / 180;
  return fmt::format(
      R"({{"surface": {{"plugin": "grid", "nodes": [5, 5], "differences": "forward"}}, "material": {{"density": 0.3}},
        "energies": [{{"plugin": "stretching", "eta": 0.1}}],
        "forces": [{{"plugin": "gravity", "acceleration": [{}, 0, {}]}}],
        "colliders": [{{"plugin": "plane", "friction": {}}}],
        "integrator": {{"plugin": "semi_implicit", "step": 0.01}}, "duration": 0.5}})",
      9.81 * std::sin(angle), -9.81 * std::cos(angle), friction);
}

TEST(Contact, AStepFollowsCoulombsLaw) {
  for (const auto& [degrees, friction] : {std::pair(30.0, 0.2), {30.0, 0.0}, {60.0, 1.0}}) {
    Simulation s = simulation_from_text(on_a_slope(degrees, friction));
    ASSERT_FALSE(test::run_to_end(s));
    const double angle = degrees * std::numbers::pi / 180;
    const double a = 9.81 * (std::sin(angle) - friction * std::cos(angle));
    const double n = 50, dt = 0.01;
    const NodeVectors moved = s.state().r - s.system().surface().initial();
    EXPECT_NEAR(moved.col(0).minCoeff(), a * dt * dt * n * (n + 1) / 2, 1e-12);
    EXPECT_NEAR(moved.col(0).maxCoeff(), a * dt * dt * n * (n + 1) / 2, 1e-12);
    EXPECT_NEAR(s.state().v.col(0).mean(), a * dt * n, 1e-12);
    EXPECT_LT(moved.col(2).cwiseAbs().maxCoeff(), 1e-15);
  }
}

/// Inside an implicit step Coulomb's law holds as exactly as the step is solved.
TEST(Contact, ImplicitStepsFollowCoulombsLaw) {
  for (const char* integrator : {"backward_euler", "bdf2", "implicit_midpoint"})
    for (const auto& [degrees, friction] :
         {std::pair(30.0, 0.2), {30.0, 0.0}, {60.0, 1.0}, {20.0, 0.4}}) {
      Simulation s = simulation_from_text(
          on_a_slope(degrees, friction),
          {{"/integrator",
            fmt::format(R"({{"plugin": "{}", "step": 0.01, "tolerance": 1e-11}})", integrator)}});
      ASSERT_FALSE(test::run_to_end(s)) << integrator;
      const double angle = degrees * std::numbers::pi / 180, T = 0.5;
      const double a = std::max(0.0, 9.81 * (std::sin(angle) - friction * std::cos(angle)));
      const NodeVectors moved = s.state().r - s.system().surface().initial();
      // Backward Euler is ahead by a T dt/2 there; the first step of bdf2 is its step, and in the
      // first of any other friction starts from nothing.
      const double late = std::string(integrator) == "backward_euler" ? 0.5 * a * T * 0.01 : 0;
      EXPECT_NEAR(moved.col(0).mean(), 0.5 * a * T * T + late, 0.2 * a * 0.01 * T + 1e-9)
          << integrator << ' ' << degrees;
      EXPECT_NEAR(s.state().v.col(0).mean(), a * T, 0.03 * a * T + 1e-9) << integrator;
      EXPECT_LT(moved.col(2).cwiseAbs().maxCoeff(), 1e-9) << integrator;
    }
}

TEST(Contact, WhatIsLessSteepThanFrictionStays) {
  Simulation s = simulation_from_text(on_a_slope(20, 0.4));  // tan 20° = 0.364
  ASSERT_FALSE(test::run_to_end(s));
  EXPECT_LT((s.state().r - s.system().surface().initial()).cwiseAbs().maxCoeff(), 1e-15);
}

std::string falling(const std::string& colliders, bool held = false) {
  return R"({"surface": {"plugin": "grid", "nodes": [17, 17], "differences": "forward"},
    "material": {"density": 0.1, "damping": 0.05},
    "energies": [{"plugin": "stretching", "eta": 1.0}, {"plugin": "bending_variational", "xi": 1e-4}],
    "forces": [{"plugin": "gravity", "acceleration": [0, 0, -2]}],
    "constraints": [)" +
         std::string(held ? R"({"plugin": "pin", "where": {"corners": "all"}})" : "") +
         R"(], "colliders": [)" + colliders +
         R"(], "integrator": {"plugin": "semi_implicit", "step": 0.005}, "duration": 1.0})";
}

TEST(Contact, NoNodeIsInsideAtAnyStep) {
  Simulation s = simulation_from_text(falling(
      R"({"plugin": "sphere", "centre": [0.5, 0.5, -0.3], "radius": 0.25, "thickness": 0.01},
                 {"plugin": "plane", "point": [0, 0, -0.4]})"));
  bool touched = false;
  while (s.steps() < s.scene().steps()) {
    s.step();
    const NodeVectors& r = s.state().r;
    const NodeValues from_centre =
        (r.rowwise() - Eigen::RowVector3d(0.5, 0.5, -0.3)).rowwise().norm();
    ASSERT_GE(from_centre.minCoeff(), 0.26 - 1e-12) << s.steps();
    ASSERT_GE(r.col(2).minCoeff(), -0.4 - 1e-12) << s.steps();
    touched = touched || from_centre.minCoeff() < 0.26 + 1e-9;
  }
  EXPECT_TRUE(touched);
}

TEST(Contact, NoNodeIsInsideAfterImplicitSteps) {
  for (const char* integrator : {"backward_euler", "bdf2", "implicit_midpoint"}) {
    Simulation s = simulation_from_text(
        falling(
            R"({"plugin": "sphere", "centre": [0.5, 0.5, -0.3], "radius": 0.25, "thickness": 0.01},
                 {"plugin": "plane", "point": [0, 0, -0.4]})"),
        {{"/integrator", fmt::format(R"({{"plugin": "{}", "step": 0.02}})", integrator)}});
    bool touched = false;
    while (s.steps() < s.scene().steps()) {
      s.step();
      const NodeVectors& r = s.state().r;
      const NodeValues from_centre =
          (r.rowwise() - Eigen::RowVector3d(0.5, 0.5, -0.3)).rowwise().norm();
      ASSERT_GE(from_centre.minCoeff(), 0.26 - 1e-5) << integrator << ' ' << s.steps();
      ASSERT_GE(r.col(2).minCoeff(), -0.4 - 1e-5) << integrator << ' ' << s.steps();
      touched = touched || from_centre.minCoeff() < 0.26 + 1e-5;
    }
    EXPECT_TRUE(touched) << integrator;
  }
}

TEST(Contact, ClearanceIsThatOfTheNearestBody) {
  Simulation s = simulation_from_text(
      falling(R"({"plugin": "sphere", "centre": [0.5, 0.5, -0.3], "radius": 0.25},
                 {"plugin": "plane", "point": [0, 0, -0.4]})"));
  NodeVectors points(2, 3);
  points << 0.5, 0.5, 0.2, 10, 10, 0;
  const NodeValues clearance = s.system().contact().clearance(0, points);
  EXPECT_DOUBLE_EQ(clearance[0], 0.25);
  EXPECT_DOUBLE_EQ(clearance[1], 0.4);
}

TEST(Contact, TheMirroredWorldIsTheReflection) {
  Simulation s = simulation_from_text(falling(
      R"({"plugin": "box", "centre": [0.4, 0.5, -0.3], "size": [0.5, 0.4, 0.5], "rounding": 0.1})"));
  const auto mirrored = s.mirrored();
  for (int i = 0; i < 100; ++i) {
    s.step();
    mirrored->step();
  }
  NodeVectors there = mirrored->state().r;
  there.col(2) *= -1;
  EXPECT_EQ(there, s.state().r);
}

TEST(Contact, NodesThatAreHeldStay) {
  Simulation s = simulation_from_text(
      falling(R"({"plugin": "sphere", "centre": [0, 0, -0.005], "radius": 0.02})", true));
  EXPECT_FALSE(test::run_to_end(s));
  EXPECT_EQ(s.state().r.row(0), s.system().surface().initial().row(0));
}

TEST(Contact, AFreeNodeInsideAtFirstIsBadInput) {
  try {
    (void)simulation_from_text(falling(R"({"plugin": "plane", "point": [0, 0, -1]},
                   {"plugin": "sphere", "centre": [0.5, 0.5, 0], "radius": 0.3})"));
    FAIL();
  } catch (const InputError& e) {
    EXPECT_NE(std::string(e.what()).find("/colliders/1"), std::string::npos) << e.what();
    EXPECT_NE(std::string(e.what()).find("node 144 begins 0.3 m inside"), std::string::npos)
        << e.what();
  }
}

}  // namespace
}  // namespace deform
