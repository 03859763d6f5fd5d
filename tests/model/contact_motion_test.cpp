/// What follows from contact: restitution, bodies that move, forces, work; equilibria in contact.
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "deform/record/energy_account.h"

#include "model/support/contact_scene.h"
#include "model/support/simulate.h"

namespace deform {
namespace {

using test::Ended;
using test::Method;
using test::methods;
using test::name_of;
using test::plane;
using test::sheet;
using test::simulation_from_text;
using test::velocity;

const Replacement kGravity{"/forces/-", R"({"plugin": "gravity"})"};

/// v⁺ = −e v⁻ along the normal, wherever in a step the impact is, and p_t = μ p_n across it.
TEST(Restitution, AnImpactGivesBackItsPartOfTheSpeedOfApproach) {
  for (const Method& m : methods())
    for (const double e : {0.0, 0.4, 1.0})
      for (const double height : {0.01, 0.0103, 0.0119}) {
        Ended s(m, 0.001, 0.02,
                {velocity(3, -2), plane(-height, 0.3, fmt::format(R"(, "restitution": {})", e))});
        EXPECT_NEAR(s.state().v.col(2).mean(), 2 * e, 1e-6) << name_of(m) << ' ' << e;
        EXPECT_NEAR(s.state().v.col(0).mean(), 3 - 0.3 * 2 * (1 + e), 1e-6)
            << name_of(m) << ' ' << e;
      }
}

/// A sheet that lies on a floor has come with no speed: it stays, whatever the restitution.
TEST(Restitution, WhatRestsStays) {
  for (const Method& m : methods()) {
    Ended s(m, 0.01, 0.3, {kGravity, plane(0, 0.3, R"(, "restitution": 0.8)")});
    EXPECT_LE(s.state().r.col(2).cwiseAbs().maxCoeff(), 1e-9) << name_of(m);
    EXPECT_LE(s.state().v.rowwise().norm().maxCoeff(), 1e-9) << name_of(m);
  }
}

/// A belt that moves at 1 m/s: what lies on it gains μ g t until it goes along.
TEST(MovingCollider, ABeltCarriesByFriction) {
  const std::string belt = R"(, "times": [0, 10], "displacements": [[0, 0, 0], [10, 0, 0]])";
  for (const Method& m : methods())
    for (const double duration : {0.2, 0.8}) {
      Ended s(m, 0.005, duration, {kGravity, plane(0, 0.2, belt)});
      const double v = std::min(0.2 * 9.81 * duration, 1.0);
      EXPECT_NEAR(s.state().v.col(0).mean(), v, 0.011) << name_of(m) << ' ' << duration;
      const double slowest = v == 1 ? s.state().v.col(0).minCoeff() : 1;
      EXPECT_NEAR(slowest, 1, 1e-6) << name_of(m);
      EXPECT_LE(s.state().v.col(2).cwiseAbs().maxCoeff(), 1e-8) << name_of(m);
    }
}

/// A floor that rises takes along what lies on it.
TEST(MovingCollider, AFloorLifts) {
  const std::string lift = R"(, "times": [0, 1], "displacements": [[0, 0, 0], [0, 0, 0.5]])";
  for (const Method& m : methods()) {
    Ended s(m, 0.01, 0.4, {kGravity, plane(0, 0.3, lift)});
    EXPECT_NEAR(s.state().r.col(2).minCoeff(), 0.2, 1e-8) << name_of(m);
    EXPECT_NEAR(s.state().v.col(2).maxCoeff(), 0.5, 1e-6) << name_of(m);
  }
}

/// On a table that turns slowly everything that sticks turns along: x = R(t) X.
TEST(MovingCollider, ATurntableTurnsWhatSticks) {
  const double angle = 0.25;  // in the end; from rest by a corner at t = 0 that friction can follow
  const std::string turn = fmt::format(
      R"(, "times": [0, 1], "rotations": [[0, 0, 0], [0, 0, {}]], "pivot": [0.5, 0.5, 0])", angle);
  const std::string energies = R"([{"plugin": "stretching", "eta": 100}])";
  for (const char* integrator : {"backward_euler", "bdf2", "implicit_midpoint"}) {
    Ended s({integrator, energies}, 0.01, 1, {kGravity, plane(0, 50, turn)});
    for (Index a = 0; a < 9; ++a) {
      const Vec3 X = s.system().surface().initial().row(a).transpose() -
                     Eigen::RowVector3d(.5, .5, 0).transpose();
      const Vec3 x{0.5 + X.x() * std::cos(angle) - X.y() * std::sin(angle),
                   0.5 + X.x() * std::sin(angle) + X.y() * std::cos(angle), 0};
      EXPECT_LE((s.state().r.row(a).transpose() - x).norm(), 2e-3) << integrator << ' ' << a;
    }
  }
}

/// A ball that moves through a sheet's place within a step meets it.
TEST(MovingCollider, AFastBodyDoesNotPass) {
  for (const Method& m : methods()) {
    Ended s(m, 0.01, 0.05,
            {{"/limits", R"({"distance": 1e5})"},
             {"/colliders/-",
              R"({"plugin": "box", "centre": [0.5, 0.5, -1], "size": [4, 4, 0.002], "friction": 0,
                  "times": [0, 1], "displacements": [[0, 0, 0], [0, 0, 100]]})"}});
    EXPECT_GE(s.state().r.col(2).minCoeff(), 4.001 - 1e-6) << name_of(m);
  }
}

/// At rest a floor pushes with the weight; the first steps' mean forces balance momentum.
TEST(ContactForces, BalanceWeightAndMomentum) {
  for (const Method& m : methods()) {
    std::vector<Replacement> scene{kGravity, velocity(0.4, -0.3), plane(-0.012, 0.3)};
    if (test::is_implicit(m)) {
      scene.push_back({"/integrator/tolerance", "1e-12"});
      scene.push_back({"/integrator/iterations", "500"});
    }
    Simulation s = sheet(m, 0.01, 0.3, scene);
    const double mass = s.system().mass().sum(), dt = 0.01;
    const auto momentum = [&] { return Vec3(s.system().mass().transpose() * s.state().v); };
    while (s.steps() < s.scene().steps()) {
      const Vec3 before = momentum();
      s.step();
      const ContactReport& contact = s.system().step_report().contact;
      Vec3 impulse(0, 0, -mass * 9.81 * dt);
      if (contact.any())
        impulse += (contact.normal_impulse() + contact.friction_impulse()).colwise().sum();
      EXPECT_NEAR(contact.time(), dt, 1e-15);
      // Positions are found to 1e-13 of the size.
      EXPECT_LE((momentum() - before - impulse).norm(), 3e-10) << name_of(m) << ' ' << s.steps();
    }
    const Vec3 push = s.system().step_report().contact.normal_impulse().colwise().sum() / dt;
    EXPECT_NEAR(push.z(), mass * 9.81, 1e-8) << name_of(m);
  }
}

/// What slides until it stands has lost its kinetic energy to friction.
TEST(ContactForces, FrictionsWorkIsTheEnergyThatASlideLoses) {
  for (const Method& m : methods()) {
    Simulation s = sheet(m, 0.001, 0.3, {kGravity, velocity(0.5, 0), plane(0, 0.3)});
    EnergyAccount account(s.system());
    NodeVectors before = s.state().r;
    const auto frame = [&] { return Frame{s.steps(), 0.001, s.state(), before, s.system()}; };
    account.start(frame());
    while (s.steps() < s.scene().steps()) {
      before = s.state().r;
      s.step();
      account.add_part(frame(), 0.001, EnergyAccount::End::of_step);
    }
    const EnergyFigures figures = account.figures(frame());
    EXPECT_NEAR(figures.friction, -0.5 * 0.25, 1e-3 * 0.125) << name_of(m);
    EXPECT_NEAR(figures.drift(), 0, 1e-3 * 0.125) << name_of(m);
    EXPECT_NEAR(figures.contact, 0, 1e-6) << name_of(m);
  }
}

Simulation relaxed(const std::vector<Replacement>& replacements) {
  return simulation_from_text(
      R"({"surface": {"plugin": "grid", "nodes": [9, 9], "size": [1, 1]},
          "material": {"density": 1, "damping": 5},
          "energies": [{"plugin": "koiter", "young": 1e5, "poisson": 0.3, "thickness": 0.02}],
          "forces": ["gravity"], "constraints": [], "colliders": [],
          "integrator": {"plugin": "static", "step": 1}, "duration": 1})",
      replacements);
}

/// What nothing else holds falls onto a floor and lies there, flat, with its weight on it.
TEST(StaticContact, ASheetFallsOntoAFloor) {
  Simulation s = relaxed({plane(-0.3, 0.3)});
  s.step();
  EXPECT_NEAR(s.state().r.col(2).minCoeff(), -0.3, 1e-12);
  EXPECT_NEAR(s.state().r.col(2).maxCoeff(), -0.3, 1e-9);
  const Vec3 push = s.system().step_report().contact.normal_impulse().colwise().sum() /
                    s.system().step_report().contact.time();
  EXPECT_NEAR(push.z(), s.system().mass().sum() * 9.81, 1e-6);
}

/// A plate that is held along a side and sags onto a slope: what motion with damping comes to.
TEST(StaticContact, IsWhatDampedMotionComesTo) {
  const std::vector<Replacement> scene{
      {"/constraints/-", R"({"plugin": "pin", "where": {"box": [[0, 0], [0.13, 1]]}})"},
      {"/colliders/-",
       R"({"plugin": "plane", "point": [0, 0, -0.15], "normal": [0.2, 0, 1], "friction": 0})"}};
  Simulation rests = relaxed(scene);
  rests.step();
  std::vector<Replacement> moving = scene;
  moving.push_back(
      {"/integrator", R"({"plugin": "backward_euler", "step": 0.05, "tolerance": 1e-8})"});
  moving.push_back({"/duration", "20"});
  Simulation moves = relaxed(moving);
  ASSERT_FALSE(test::run_to_end(moves));
  EXPECT_LE((rests.state().r - moves.state().r).cwiseAbs().maxCoeff(), 1e-6);
  EXPECT_TRUE(rests.system().step_report().contact.any());
}

/// A ball that the scene presses into a held sheet.
TEST(StaticContact, ABodyIsPressedIntoASheet) {
  Simulation s =
      relaxed({{"/forces", "[]"},
               {"/constraints/-", R"({"plugin": "pin", "where": {"boundary": ["left", "right"]}})"},
               {"/colliders/-",
                R"({"plugin": "sphere", "centre": [0.5, 0.5, -0.31], "radius": 0.3, "friction": 0.2,
            "times": [0, 1], "displacements": [[0, 0, 0], [0, 0, 0.15]]})"}});
  s.step();
  const double top = -0.31 + 0.3 + 0.15;
  EXPECT_NEAR(s.state().r(40, 2), top, 1e-9);  // the node in the middle
  EXPECT_LE((s.state().r.col(2).array() - top).maxCoeff(), 1e-9);
  const Vec3 push = s.system().step_report().contact.normal_impulse().colwise().sum();
  EXPECT_GT(push.z(), 0);
}

/// Damping slows pseudo-steps, and changes nothing of where they end.
TEST(StaticContact, DampingDoesNotCount) {
  for (const char* damping : {"1e4", "1e8"}) {
    Simulation s = relaxed({plane(-0.3, 0.3), {"/material/damping", damping}});
    s.step();
    EXPECT_NEAR(s.state().r.col(2).maxCoeff(), -0.3, 1e-9) << damping;
  }
}

/// A turntable that has come back to where it was has rubbed all the way round: friction is μ N.
TEST(StaticContact, AWholeTurnRubs) {
  Simulation s = relaxed(
      {{"/constraints/-", R"({"plugin": "pin", "where": {"boundary": ["left"]}})"},
       plane(0, 0.9, R"(, "times": [0, 1], "rotations": [[0, 0, 0], [0, 0, 6.283185307179586]])")});
  s.step();
  const ContactReport& contact = s.system().step_report().contact;
  const double ratio = contact.friction_impulse().rowwise().norm().sum() /
                       contact.normal_impulse().rowwise().norm().sum();
  EXPECT_NEAR(ratio, 0.9, 1e-3);
}

TEST(StaticContact, WhatNothingStopsHasNoEquilibrium) {
  Simulation s = relaxed({{"/colliders/-", R"({"plugin": "sphere", "centre": [9, 9, -9]})"}});
  try {
    s.step();
    FAIL() << "it came to rest";
  } catch (const Diverged& e) {
    EXPECT_NE(std::string(e.what()).find("nothing stops the surface"), std::string::npos)
        << e.what();
  }
}

}  // namespace
}  // namespace deform
