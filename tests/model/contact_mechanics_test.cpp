/// Contact: impacts, slopes, nodes that are partly held, and bodies thinner than a step's way,
/// under every integrator.
#include <cmath>
#include <numbers>
#include <string>
#include <tuple>
#include <vector>

#include <fmt/format.h>

#include "model/support/contact_scene.h"
#include "model/support/simulate.h"

namespace deform {
namespace {

using test::simulation_from_text;

using test::Ended;
using test::largest_speed;
using test::Method;
using test::methods;
using test::name_of;
using test::plane;
using test::sheet;
using test::velocity;

TEST(ContactMechanics, AnImpactTakesAllOfTheNormalVelocity) {
  for (const Method& m : methods())
    for (const double height : {0.1, 0.1003, 0.1019}) {  // wherever in a step it happens
      Ended s(m, 0.001, 0.06, {velocity(0, -2), plane(-height, 0.3)});
      EXPECT_LE(largest_speed(s), 1e-8) << name_of(m);
      EXPECT_NEAR(s.state().r.col(2).minCoeff(), -height, 1e-9) << name_of(m);
      EXPECT_NEAR(s.state().r.col(2).maxCoeff(), -height, 1e-9) << name_of(m);
    }
}

/// p_t = μ p_n, or as much as it takes to stop it.
TEST(ContactMechanics, AnImpactIsResistedByFrictionTimesItsImpulse) {
  for (const Method& m : methods())
    for (const double height : {0.01, 0.0103, 0.0119})
      for (const auto& [before, after] : {std::pair(3.0, 2.4), {0.5, 0.0}, {-1.0, -0.4}}) {
        Ended s(m, 0.001, 0.02, {velocity(before, -2), plane(-height, 0.3)});
        EXPECT_NEAR(s.state().v.col(0).mean(), after, 1e-6) << name_of(m) << ' ' << before;
        EXPECT_LE(s.state().v.col(2).cwiseAbs().maxCoeff(), 1e-8) << name_of(m) << ' ' << before;
      }
}

/// a = g (sin α − μ cos α), or rest.
TEST(ContactMechanics, WhatSlidesFollowsCoulombsLaw) {
  const double angle = 25 * std::numbers::pi / 180, T = 0.5, dt = 0.005;
  const double along = 9.81 * std::sin(angle), into = 9.81 * std::cos(angle);
  const Replacement gravity{
      "/forces/-",
      fmt::format(R"({{"plugin": "gravity", "acceleration": [{}, 0, {}]}})", along, -into)};
  for (const Method& m : methods())
    for (const double friction : {0.0, 0.1, 0.3, 0.6}) {
      Ended s(m, dt, T, {gravity, plane(0, friction)});
      const double a = std::max(0.0, along - friction * into);
      EXPECT_NEAR(s.state().v.col(0).mean(), a * T, 1e-6) << name_of(m) << ' ' << friction;
      // The exact way, but for half a step's that methods of first order are ahead.
      const NodeVectors moved = s.state().r - s.system().surface().initial();
      EXPECT_NEAR(moved.col(0).mean(), a * T * T / 2, a * T * dt / 2 + 1e-6)
          << name_of(m) << ' ' << friction;
      EXPECT_LE(moved.col(2).cwiseAbs().maxCoeff(), 1e-9) << name_of(m) << ' ' << friction;
    }
}

TEST(ContactMechanics, ANodeThatIsPartlyHeldHasContactWhereItIsFree) {
  const Replacement gravity{"/forces/-", R"({"plugin": "gravity"})"};
  for (const Method& m : methods())
    for (const char* components : {R"(["y"])", R"(["x", "y"])"}) {
      const Replacement pin{
          "/constraints/-",
          fmt::format(
              R"({{"plugin": "pin", "where": {{"box": [[0, 0], [1, 1]]}}, "components": {}}})",
              components)};
      Ended s(m, 0.01, 0.3, {gravity, pin, plane(-0.1, 0.3)});
      EXPECT_NEAR(s.state().r.col(2).minCoeff(), -0.1, 1e-9) << name_of(m);
      EXPECT_LE(largest_speed(s), 1e-9) << name_of(m);
      EXPECT_EQ(s.state().r.col(1), s.system().surface().initial().col(1)) << name_of(m);
    }
}

/// Free along x alone, a slope of 45° in x and z stops it where it comes to it.
TEST(ContactMechanics, ANodeIsPushedAlongWhatIsFreeOfIt) {
  const Replacement pin{"/constraints/-",
                        R"({"plugin": "pin", "where": {"box": [[0, 0], [1, 1]]},
                            "components": ["y", "z"]})"};
  const Replacement slope{"/colliders/-",
                          R"({"plugin": "plane", "point": [0.2, 0, 0], "normal": [-1, 0, 1],
                              "friction": 0})"};
  for (const Method& m : methods()) {
    Simulation s =
        sheet(m, 0.01, 0.2, {{"/surface/size", "[0.1, 0.1]"}, velocity(1, 0), pin, slope});
    ASSERT_FALSE(test::run_to_end(s)) << name_of(m);
    EXPECT_NEAR(s.state().r.col(0).maxCoeff(), 0.2, 1e-9) << name_of(m);
    EXPECT_LE(s.state().r.col(2).cwiseAbs().maxCoeff(), 1e-15) << name_of(m);
  }
}

/// On rails along z, a body's slope stops it where it comes to it, whatever the friction: there is
/// no direction that it could slide in.
TEST(ContactMechanics, FrictionDoesNotPushANodeAlongTheNormal) {
  const Replacement pin{"/constraints/-",
                        R"({"plugin": "pin", "where": {"box": [[0, 0], [1, 1]]},
                            "components": ["x", "y"]})"};
  const Replacement gravity{"/forces/-", R"({"plugin": "gravity"})"};
  for (const Method& m : methods())
    for (const double steep : {0.1, 0.3, 0.7071})
      for (const double friction : {0.3, 0.8}) {
        const Replacement slope{
            "/colliders/-",
            fmt::format(R"({{"plugin": "plane", "point": [0, 0, -0.1], "normal": [{}, 0, {}],
                             "friction": {}}})",
                        -std::sqrt(1 - steep * steep), steep, friction)};
        Ended s(m, 0.01, 0.3,
                {{"/surface/size", "[1e-4, 1e-4]"},
                 {"/limits", R"({"distance": 1e6})"},
                 pin,
                 gravity,
                 slope});
        EXPECT_NEAR(s.state().r.col(2).maxCoeff(), -0.1, 2e-3) << name_of(m) << ' ' << steep;
        EXPECT_NEAR(s.state().r.col(2).minCoeff(), -0.1, 2e-3) << name_of(m) << ' ' << steep;
        EXPECT_LE(largest_speed(s), 1e-8) << name_of(m) << ' ' << steep << ' ' << friction;
      }
}

/// In a symmetry's plane.
TEST(ContactMechanics, TiedNodesHaveContact) {
  const Replacement gravity{"/forces/-", R"({"plugin": "gravity"})"};
  const Replacement symmetry{
      "/constraints/-", R"({"plugin": "symmetry", "where": {"boundary": "left"}, "plane": "x"})"};
  for (const Method& m : methods()) {
    // The first takes no such ties; energies without a potential do not converge with them, contact
    // or none.
    if (m.integrator == "semi_implicit" || m.energies != "[]") continue;
    Ended s(m, 0.01, 0.3, {{"/surface/nodes", "[5, 5]"}, gravity, symmetry, plane(-0.1, 0.3)});
    EXPECT_NEAR(s.state().r.col(2).minCoeff(), -0.1, 1e-8) << name_of(m);
    EXPECT_LE(largest_speed(s), 1e-6) << name_of(m);
  }
}

struct Obstacle {
  std::string collider;
  double top;  // where a node over its middle stops
};

/// Bodies thinner than a step's way, met at 20 and 100 m/s, in whatever part of a step.
TEST(ContactMechanics, NothingPassesABodyWithinAStep) {
  const std::vector<Obstacle> obstacles{
      {R"({"plugin": "box", "centre": [0, 0, -0.15], "size": [4, 4, 0.1]})", -0.1},
      {R"({"plugin": "box", "centre": [0, 0, -2.001], "size": [4, 4, 0.002]})", -2},
      {R"({"plugin": "box", "centre": [0, 0, -2.001], "size": [4, 4, 0.002], "rounding": 0.001,
           "thickness": 0.01})",
       -1.99},
      {R"({"plugin": "sphere", "centre": [0, 0, -1.55], "radius": 0.05})", -1.5},
      {R"({"plugin": "cylinder", "centre": [0, 0, -1.72], "axis": [0, 1, 0], "radius": 0.02,
           "height": 1})",
       -1.7}};
  for (const Method& m : methods())
    for (const auto& [collider, top] : obstacles)
      for (const double speed : {20.0, 100.0}) {
        // Beside the middle of what is round, a node slides along its tangent for a part of a step.
        const double slack = collider.find("box") == std::string::npos ? 5e-3 : 1e-6;
        Simulation s = sheet(m, 0.01, 0.15,
                             {velocity(0, -speed),
                              {"/surface/size", "[0.001, 0.001]"},
                              {"/limits", R"({"distance": 1e5})"},
                              {"/colliders/-", collider}});
        ASSERT_FALSE(test::run_to_end(s)) << name_of(m);
        EXPECT_NEAR(s.state().r.col(2).maxCoeff(), top, slack) << name_of(m) << collider << speed;
        EXPECT_NEAR(s.state().r.col(2).minCoeff(), top, slack) << name_of(m) << collider << speed;
        EXPECT_LE(largest_speed(s), 0.1 * speed) << name_of(m) << collider << speed;
      }
}

/// Beside a body nothing is stopped by it.
TEST(ContactMechanics, WhatPassesBesideABodyGoesOn) {
  for (const Method& m : methods()) {
    Ended s(
        m, 0.01, 0.1,
        {velocity(0, -100),
         {"/limits", R"({"distance": 1e5})"},
         {"/colliders/-", R"({"plugin": "box", "centre": [-1.0001, 0, -5], "size": [2, 2, 0.1]})"},
         {"/colliders/-", R"({"plugin": "sphere", "centre": [1.501, 0.5, -5], "radius": 0.5})"},
         {"/colliders/-", R"({"plugin": "sphere", "centre": [0, 0, -1e100], "radius": 1})"}});
    EXPECT_NEAR(s.state().r.col(2).maxCoeff(), -10, 1e-9) << name_of(m);
    EXPECT_NEAR(s.state().r.col(2).minCoeff(), -10, 1e-9) << name_of(m);
  }
}

/// A chord of a sphere, whose ends are outside and less than 60° apart: it is met at the first end,
/// and what is left of the step goes along the tangent there.
TEST(ContactMechanics, WhatCutsThroughASphereMeetsIt) {
  const double begin = -0.6, end = 0.6;
  for (const Method& m : methods())
    for (const double height : {0.87, 0.9, 0.95}) {
      Ended s(m, 0.05, 0.05,
              {velocity((end - begin) / 0.05, 0),
               {"/surface/size", "[1e-4, 1e-4]"},
               {"/limits", R"({"distance": 1e6})"},
               {"/surface/initial",
                fmt::format(R"({{"plugin": "formula", "x": "a1 - 0.6", "y": "a2", "z": "{}"}})",
                            height)},
               {"/colliders/-",
                R"({"plugin": "sphere", "centre": [0, 0, 0], "radius": 1, "friction": 0})"}});
      const Vec3 n(-std::sqrt(1 - height * height), 0, height), to(end, 0, height);
      const Vec3 right = to - (n.dot(to) - 1) * n;
      EXPECT_NEAR((Vec3(s.state().r.row(4).transpose()) - right).norm(), 0, 1e-3)
          << name_of(m) << ' ' << height;
    }
}

/// A force that draws nodes around a body within a step: Newton's method begins with a guess behind
/// the body, but the step's own way passes beside it.
TEST(ContactMechanics, WaysToGuessesDoNotCount) {
  const auto solved = [](const std::string& colliders) {
    Simulation s = sheet({"backward_euler", "[]"}, 0.1, 0.1,
                         {{"/surface/size", "[0.02, 0.02]"},
                          {"/surface/initial",
                           R"({"plugin": "formula", "x": "a1 - 0.31", "y": "a2 - 0.01",
                               "z": "0"})"},
                          {"/material/density", "0.2"},
                          {"/velocity", "[6, 0, 0]"},
                          {"/forces/-",
                           R"({"plugin": "spring", "anchor": [0.3, 1, 0], "stiffness": 0.008,
                               "where": {"box": [[0, 0], [0.02, 0.02]]}})"},
                          {"/colliders", colliders}});
    EXPECT_FALSE(test::run_to_end(s));
    return s.state().r;
  };
  const NodeVectors without = solved("[]");
  const NodeVectors with =
      solved(R"([{"plugin": "sphere", "centre": [0, 0, 0], "radius": 0.1, "friction": 0}])");
  EXPECT_NEAR(without(4, 1), 0.5, 0.1);  // beside the body
  EXPECT_LE((with - without).cwiseAbs().maxCoeff(), 1e-8);
}

/// What is compressed has a tangent that is negative in places; contact's penalties are not.
TEST(ContactMechanics, ACompressedSheetDoesNotPassAPlane) {
  for (const char* integrator : {"backward_euler", "bdf2", "implicit_midpoint"}) {
    Simulation s =
        sheet({integrator, R"([{"plugin": "edge_springs", "stiffness": 50}])"}, 0.05, 0.2,
              {{"/surface/initial",
                R"({"plugin": "formula", "x": "0.5*a1", "y": "0.5*a2", "z": "1e-4"})"},
               {"/material/density", "0.01"},
               {"/forces/-", R"({"plugin": "gravity"})"},
               {"/constraints/-",
                R"({"plugin": "pin", "where": {"boundary": "all"},
                               "components": ["x", "y"]})"},
               plane(0, 0)});
    while (s.steps() < s.scene().steps()) {
      s.step();
      EXPECT_GE(s.state().r.col(2).minCoeff(), -1e-4) << integrator << ' ' << s.steps();
    }
  }
}

/// A sheet of rubber thrown onto a plane, where it stretches: contact takes energy, friction too.
TEST(ContactMechanics, ContactGivesNoEnergy) {
  for (const char* integrator : {"implicit_midpoint", "bdf2", "runge_kutta"}) {
    Simulation s = simulation_from_text(fmt::format(
        R"({{"surface": {{"plugin": "grid", "nodes": [7, 7], "differences": "symmetric",
                        "border": "one_sided", "weights": "area"}},
            "material": {{"density": 0.3}}, "velocity": [1, 0, -1],
            "energies": [{{"plugin": "stretching", "eta": 20}}],
            "colliders": [{{"plugin": "sphere", "centre": [0.5, 0.5, -0.32], "radius": 0.3}}],
            "integrator": {{"plugin": "{}", "step": 0.001}}, "duration": 0.4}})",
        integrator));
    const auto energy = [&] {
      const State& state = s.state();
      return s.system().evaluator().potential(state) +
             0.5 * s.system().mass().dot(state.v.rowwise().squaredNorm());
    };
    const double begun = energy();
    double lowest = begun;
    while (s.steps() < s.scene().steps()) {
      s.step();
      lowest = std::min(lowest, energy());
      EXPECT_LE(energy(), lowest + 1e-3 * begun) << integrator << ' ' << s.steps();
    }
    EXPECT_LT(lowest, 0.95 * begun) << integrator;  // there was an impact
  }
}

TEST(ContactMechanics, GoesOnFromWhatWasSaved) {
  for (const char* integrator : {"backward_euler", "bdf2", "implicit_midpoint"}) {
    const auto begun = [&] {
      return sheet({integrator, "[]"}, 0.01, 0.4,
                   {{"/forces/-", R"({"plugin": "gravity"})"},
                    {"/velocity", "[0.3, 0, 0]"},
                    plane(-0.005, 0.3)});
    };
    Simulation s = begun(), resumed = begun();
    for (int i = 0; i < 20; ++i) s.step();
    Memory memory;
    s.save(memory);
    resumed.load(memory);
    for (int i = 0; i < 20; ++i) {
      s.step();
      resumed.step();
      EXPECT_EQ(s.state().r, resumed.state().r) << integrator << ' ' << i;
      EXPECT_EQ(s.state().v, resumed.state().v) << integrator << ' ' << i;
    }
  }
}

/// What a checkpoint says of friction is used as places in arrays.
TEST(ContactMechanics, AMemoryThatCannotBeIsBadInput) {
  const auto begun = [] {
    return sheet({"backward_euler", "[]"}, 0.01, 0.1,
                 {{"/forces/-", R"({"plugin": "gravity"})"}, plane(0, 0.3)});
  };
  Simulation s = begun();
  s.step();
  Memory memory;
  s.save(memory);
  const auto entry = [&](const std::string& end) {
    for (const auto& [name, numbers] : memory.entries())
      if (name.ends_with(end)) return name;
    return std::string();
  };
  const std::string friction = entry("contact.friction");
  ASSERT_EQ(memory.entries().at(friction).size(), 9U * 9U);
  EXPECT_NO_THROW(begun().load(memory));
  const double nan = std::nan("");
  for (const auto& [name, place, value] : {std::tuple(friction, 0, 9.0),
                                           {friction, 0, -1.0},
                                           {friction, 0, 0.5},
                                           {friction, 9, 0.0},
                                           {friction, 2, nan},
                                           {friction, 5, -1.0},
                                           {friction, 0, 1e300}}) {
    std::vector<double> numbers = memory.entries().at(name);
    numbers[static_cast<std::size_t>(place)] = value;
    Memory spoiled = memory;
    spoiled.put(name, numbers);
    EXPECT_THROW(begun().load(spoiled), InputError) << name << ' ' << place << ' ' << value;
  }
  // A collider that the scene does not have is found when there is something to touch.
  std::vector<double> numbers = memory.entries().at(friction);
  for (std::size_t i = 1; i < numbers.size(); i += 9) numbers[i] = 1;
  Memory other = memory;
  other.put(friction, numbers);
  Simulation resumed = begun();
  resumed.load(other);
  EXPECT_THROW(resumed.step(), PluginFailure);
}

}  // namespace
}  // namespace deform
