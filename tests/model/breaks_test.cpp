/// Loads and paths that are not smooth in time: impulses, orders, work, units of time.
#include <array>
#include <cmath>
#include <filesystem>
#include <map>
#include <string>

#include <fmt/format.h>

#include "deform/simulation/run.h"

#include "model/support/simulate.h"

namespace deform {
namespace {

using test::run_to_end;
using test::simulation_from_text;

/// Every method that moves.
constexpr std::array<const char*, 6> kMethods{"semi_implicit",  "symplectic_euler",  "runge_kutta",
                                              "backward_euler", "implicit_midpoint", "bdf2"};
constexpr std::array<const char*, 4> kWithErrors{"runge_kutta", "backward_euler",
                                                 "implicit_midpoint", "bdf2"};

/// A sheet of 1 kg that nothing holds and nothing deforms: a point mass.
std::string free_sheet(const std::string& forces, const std::string& integrator, double step,
                       double duration, const std::string& more = "") {
  return fmt::format(R"({{"surface": {{"plugin": "grid", "nodes": [3, 3], "size": [1, 1]}},
      "material": {{"density": 1}}, "forces": [{}],
      "integrator": {{"plugin": "{}", "step": {}{}}}, "duration": {},
      "limits": {{"distance": 1e300}}}})",
                     forces, integrator, step, more, duration);
}
std::string gravity(double g, const std::string& time) {
  return fmt::format(R"({{"plugin": "gravity", "acceleration": [0, 0, {}], "time": {}}})", g, time);
}

/// Of z, at a scene's end: velocity and place of the centre of mass.
struct Motion {
  double v = 0, z = 0;
};
Motion end_of(const std::string& text) {
  Simulation s = simulation_from_text(text);
  const auto diverged = run_to_end(s);
  EXPECT_FALSE(diverged) << (diverged ? diverged->what() : "") << text;
  const NodeValues& m = s.system().mass();
  return {m.dot(s.state().v.col(2)) / m.sum(), m.dot(s.state().r.col(2)) / m.sum()};
}

/// A pulse's impulse is F Δt, wherever it falls between steps, and whatever their length.
TEST(Breaks, PulsesGiveTheirImpulse) {
  for (const double step : {0.1, 0.02, 0.005})
    for (int place = 0; place < 12; ++place) {
      const double begin = 0.37 * step * place, width = place % 2 == 0 ? 0.01 : 0.37 * step;
      const std::string pulse = fmt::format(R"({{"pulse": [{}, {}]}})", begin, begin + width);
      const double duration = step * std::ceil((begin + width) / step + 2);
      const auto expect = [&](const char* name, const std::string& more) {
        const Motion end = end_of(free_sheet(gravity(5, pulse), name, step, duration, more));
        EXPECT_NEAR(end.v / (5 * width), 1, 1e-5) << name << more << ' ' << step << ' ' << pulse;
        return end;
      };
      const double way = 5 * width * (duration - begin - width / 2);
      for (const char* name : kMethods) {
        const Motion end = expect(name, "");
        const std::string method = name;
        // Those of second order or more are exact for forces that are constant between breaks.
        if (method == "bdf2" || method == "implicit_midpoint" || method == "runge_kutta") {
          EXPECT_NEAR(end.z, way, 1e-5 * way) << name << ' ' << step << ' ' << pulse;
        }
      }
      for (const char* name : kWithErrors) expect(name, R"(, "error": 1e-3)");
    }
}

/// Whatever is linear between its corners: the mean over a step is the load of its middle.
TEST(Breaks, RampsAndTablesGiveTheirImpulse) {
  const std::map<std::string, double> impulses{
      {R"({"ramp": [0.41, 0.49]})", 0.04 + 0.51},
      {R"({"ramp": [0, 0.25]})", 0.125 + 0.75},
      {R"({"table": [[0.11, 0], [0.13, 2], [0.37, -1], [0.38, 0]]})", 0.02 + 0.12 - 0.005},
      {"0.5", 0.5}};
  for (const auto& [profile, impulse] : impulses)
    for (const double step : {0.1, 0.02}) {
      for (const char* name : kMethods)
        EXPECT_NEAR(end_of(free_sheet(gravity(1, profile), name, step, 1)).v, impulse, 1e-5)
            << name << ' ' << step << ' ' << profile;
      for (const char* name : kWithErrors)
        EXPECT_NEAR(end_of(free_sheet(gravity(1, profile), name, step, 1, R"(, "error": 1e-3)")).v,
                    impulse, 1e-5)
            << name << ' ' << step << ' ' << profile;
    }
}

/// Every load that has a time profile ends steps at its corners.
TEST(Breaks, EveryLoadIsFeltBetweenSteps) {
  const std::string time = R"("time": {"pulse": [0.041, 0.049]})";
  const std::string right = R"("where": {"boundary": "right"})";
  for (const std::string& load :
       {R"({"plugin": "point_load", "force": [0, 0, 1], "where": {"node": 4}, )" + time + "}",
        R"({"plugin": "edge_load", "force": [0, 0, 1], )" + right + ", " + time + "}",
        R"({"plugin": "moment", "moment": 1, "axis": [0, 1, 0], )" + right + ", " + time + "}",
        R"({"plugin": "pressure", "pressure": 1, )" + time + "}",
        R"({"plugin": "spring", "anchor": [0, 0, 1], "stiffness": 1, "where": {"node": 4}, )" +
            time + "}",
        R"({"plugin": "wind", "velocity": [0, 0, 9], )" + time + "}",
        R"({"plugin": "viscous_fluid", "velocity": [0, 0, 9], )" + time + "}"})
    for (const char* name : kMethods) {
      Simulation s = simulation_from_text(free_sheet(load, name, 0.01, 0.1),
                                          {{"/surface/nodes", "[5, 5]"},
                                           {"/surface/differences", "\"symmetric\""},
                                           {"/surface/border", "\"one_sided\""}});
      while (s.steps() < 4) s.step();
      EXPECT_LT(s.state().v.cwiseAbs().maxCoeff(), 1e-10) << name << load;
      s.step();
      EXPECT_GT(s.state().v.cwiseAbs().maxCoeff(), 1e-4) << name << load;
      EXPECT_EQ(s.system().step_report().substeps, 3) << name << load;
      EXPECT_NEAR(s.system().step_report().smallest, 0.001, 1e-12) << name << load;
    }
}

/// The same scene told in another unit of time has the same trajectory.
TEST(Breaks, AnyUnitOfTimeIsAsGood) {
  const auto end = [](const std::string& name, double unit, const std::string& more) {
    const std::string text = fmt::format(
        R"({{"surface": {{"plugin": "grid", "nodes": [4, 3], "size": [1, 1], "differences": "symmetric",
                "border": "one_sided"}},
            "material": {{"density": 1, "damping": {3}}},
            "energies": [{{"plugin": "koiter", "young": {4}, "poisson": 0.3, "thickness": 0.05}}],
            "forces": [{{"plugin": "gravity", "acceleration": [0, 0, {1}],
                         "time": {{"pulse": [{5}, {6}]}}}}],
            "constraints": [{{"plugin": "move", "where": {{"boundary": "left"}},
                "times": [0, {7}, {8}], "displacements": [[0, 0, 0], [0, 0, 0.1], [0.05, 0, 0.1]]}}],
            "integrator": {{"plugin": "{0}", "step": {2}{9}}}, "duration": {10}}})",
        name, 5 / (unit * unit), 0.01 * unit, 0.3 / unit, 100 / (unit * unit), 0.023 * unit,
        0.024 * unit, 0.055 * unit, 0.081 * unit, more, 0.1 * unit);
    Simulation s = simulation_from_text(text);
    const auto diverged = run_to_end(s);
    EXPECT_FALSE(diverged) << (diverged ? diverged->what() : "");
    State state = s.state();
    state.v *= unit;
    return state;
  };
  const auto compare = [&](const std::string& name, const std::string& more, double tolerance) {
    const State second = end(name, 1, more);
    for (const double unit : {1e-9, 1e6}) {
      const State other = end(name, unit, more);
      EXPECT_LT((other.r - second.r).cwiseAbs().maxCoeff(), tolerance) << name << more << unit;
      EXPECT_LT((other.v - second.v).cwiseAbs().maxCoeff(), 100 * tolerance)
          << name << more << unit;
    }
  };
  for (const char* name : kMethods) {
    const std::string method = name;
    const bool is_implicit =
        method == "backward_euler" || method == "bdf2" || method == "implicit_midpoint";
    compare(method, is_implicit ? R"(, "tolerance": 1e-11)" : "", 1e-8);
  }
  for (const char* name : {"bdf2", "runge_kutta"}) compare(name, R"(, "error": 1e-5)", 1e-5);
}

/// Order two across jumps of loads that fall between steps, and across corners of paths.
TEST(Breaks, MethodsKeepTheirOrderAcrossThem) {
  const auto run = [](const std::string& name, double step, const std::string& more) {
    Simulation s = simulation_from_text(fmt::format(
        R"({{"surface": {{"plugin": "grid", "nodes": [6, 5], "size": [1.0, 0.8],
                "differences": "symmetric", "border": "one_sided", "weights": "area"}},
            "material": {{"density": 1.0}},
            "energies": [{{"plugin": "koiter", "young": 200, "poisson": 0.3, "thickness": 0.05}}],
            "forces": [{{"plugin": "gravity", "acceleration": [0, 0, -5],
                         "time": {{"pulse": [0.0613, 0.2337]}}}}],
            "constraints": [{{"plugin": "move", "where": {{"boundary": "left"}},
                "times": [0, 0.1171, 0.4], "displacements": [[0, 0, 0], [0, 0, 0.05], [0, 0, 0]]}}],
            "integrator": {{"plugin": "{}", "step": {}{}}}, "duration": 0.4}})",
        name, step, more));
    EXPECT_FALSE(run_to_end(s));
    return s.state().r;
  };
  const NodeVectors exact = run("runge_kutta", 1.0 / 2560, "");
  const std::string exactly = R"(, "tolerance": 1e-12)";
  for (const auto& [name, promised, more] : {std::tuple{"bdf2", 1.8, exactly},
                                             {"implicit_midpoint", 1.8, exactly},
                                             {"runge_kutta", 3.3, std::string()}}) {
    const double coarse = (run(name, 0.01, more) - exact).norm();
    const double fine = (run(name, 0.0025, more) - exact).norm();
    EXPECT_GT(std::log2(coarse / fine) / 2, promised) << name << ' ' << coarse << ' ' << fine;
  }
}

/// A path's corner between steps: what is moved has the velocity of the piece that it is on.
TEST(Breaks, MovedNodesHaveTheVelocityOfTheirPiece) {
  for (const char* name : kMethods) {
    Simulation s = simulation_from_text(fmt::format(
        R"({{"surface": {{"plugin": "grid", "nodes": [3, 3], "size": [1, 1]}},
            "constraints": [{{"plugin": "move", "where": {{"boundary": "left"}},
                "times": [0.1, 0.17, 0.2], "displacements": [[0, 0, 0], [0, 0, 0.7], [0, 0, 0.4]]}}],
            "integrator": {{"plugin": "{}", "step": 0.05}}, "duration": 0.3}})",
        name));
    for (const double velocity : {0.0, 0.0, 10.0, -10.0, 0.0, 0.0}) {
      s.step();
      for (const Index a : s.system().surface().boundary("left"))
        EXPECT_NEAR(s.state().v(a, 2), velocity, 1e-9) << name << ' ' << s.state().time;
    }
  }
}

/// Work of loads over steps with jumps: nothing is left over of a free flight.
class Account : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = (std::filesystem::temp_directory_path() / "deform_breaks_XXXXXX").string();
    ASSERT_NE(::mkdtemp(name.data()), nullptr);
    folder_ = name;
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  double figure_of(std::string text, const std::string& wanted) {
    text.insert(1, R"("probes": ["energy_balance"], "frames": {"write": false}, )");
    RunOptions options;
    options.folder = folder_ / "run";
    options.force = true;
    const RunResult result =
        run(read_scene_text(text, "scene.json", ".", *test::built_in()), test::built_in(), options);
    EXPECT_EQ(result.code, ExitCode::done) << result.reason;
    for (const auto& [header, figure] : result.figures)
      if (header.starts_with(wanted)) return figure;
    ADD_FAILURE() << "no figure " << wanted;
    return 0;
  }

  std::filesystem::path folder_;
};

TEST_F(Account, OfEnergyHasNoDriftAcrossJumpsOfLoads) {
  for (const auto& [begin, end] : {std::pair{0.0, 0.05}, {0.013, 0.047}, {0.02, 0.03}}) {
    const std::string pulse = fmt::format(R"({{"pulse": [{}, {}]}})", begin, end);
    const double speed = 10 * (end - begin), kinetic = speed * speed / 2;
    for (const char* name : {"runge_kutta", "implicit_midpoint", "bdf2"}) {
      const std::string text = free_sheet(gravity(10, pulse), name, 0.01, 0.1);
      EXPECT_NEAR(figure_of(text, "energy_balance.loads"), kinetic, 1e-6 * kinetic) << name;
      EXPECT_NEAR(figure_of(text, "energy_balance.drift"), 0, 1e-6 * kinetic) << name;
    }
    // Of first order: the way is half a step's too long, and the drift shrinks with the step.
    for (const char* name : {"semi_implicit", "symplectic_euler", "backward_euler"}) {
      const auto drift = [&](double step) {
        return figure_of(free_sheet(gravity(10, pulse), name, step, 0.1), "energy_balance.drift");
      };
      EXPECT_NEAR(drift(0.01) / drift(0.0025), 4, 2) << name << ' ' << begin;
    }
  }
}

/// What cannot be asked for is refused; what cannot be reached ends.
TEST(Breaks, ErrorsBelowRoundingAreRefused) {
  for (const char* name : kWithErrors) try {
      (void)simulation_from_text(free_sheet(gravity(1, "1"), name, 0.1, 1, R"(, "error": 1e-300)"));
      ADD_FAILURE() << name;
    } catch (const InputError& e) {
      EXPECT_NE(std::string(e.what()).find("'error' is 1e-300"), std::string::npos) << e.what();
    }
  for (const char* name : kWithErrors) {
    std::string far = free_sheet(gravity(1, "1"), name, 0.1, 1, R"(, "error": 1e-12)");
    far.replace(far.find(R"("size": [1, 1])"), 14,
                R"("size": [1, 1], "rest": {"plugin": "flat", "origin": [1e6, 0, 0]})");
    Simulation s = simulation_from_text(far);
    const auto diverged = run_to_end(s);
    ASSERT_TRUE(diverged) << name;
    EXPECT_NE(std::string(diverged->what()).find("rounding of positions"), std::string::npos)
        << diverged->what();
  }
}

/// A part that names an earlier time than it was asked about would never let a step end.
class Backwards final : public Constraint {
 public:
  void reduce(Reduction& /*reduction*/) const override {}
  void prescribe(double /*time*/, NodeVectors& /*r*/) const override {}
  [[nodiscard]] double next_break(double after) const override { return after; }
};

TEST(Breaks, APartThatGoesBackInTimeIsNamed) {
  Simulation s = simulation_from_text(free_sheet(gravity(1, "1"), "bdf2", 0.1, 1));
  const Surface& surface = s.system().surface();
  ModelParts parts;
  parts.surface = {std::shared_ptr<const Surface>(), &surface};  // the simulation's
  parts.rest = surface.rest();
  parts.mass = parts.damping = surface.areas();
  parts.constraints.push_back({"backwards", "constraint/backwards", std::make_shared<Backwards>()});
  System system(std::move(parts));
  try {
    (void)system.next_break(1);
    FAIL();
  } catch (const PluginFailure& e) {
    EXPECT_NE(std::string(e.what()).find("constraint/backwards"), std::string::npos) << e.what();
  }
}

}  // namespace
}  // namespace deform
