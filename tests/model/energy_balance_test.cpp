/// The probes `energy_balance` and `momentum`, and velocities at first.
#include <cmath>
#include <filesystem>
#include <map>
#include <string>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "deform/simulation/run.h"

#include "support/simulate.h"

namespace deform {
namespace {

namespace fs = std::filesystem;

const std::string kFree = R"({
  "surface": {"plugin": "grid", "nodes": [6, 5], "size": [1.2, 0.8],
              "initial": {"plugin": "flat", "origin": [0.3, -0.2, 0.1]}},
  "material": {"density": 0.1, "damping": 0},
  "energies": [{"plugin": "stretching", "eta": 1}],
  "integrator": {"plugin": "semi_implicit", "step": 0.01},
  "duration": 0.2,
  "frames": {"write": false}, "checkpoint": {"seconds": 0},
  "probes": ["energy_balance", "momentum"]
})";
constexpr double kMass = 0.1 * 1.2 * 0.8;  // [kg]
constexpr double kGravity = 9.81;          // [m/s²]

const Replacement kFalls{"/forces", R"([{"plugin": "gravity", "acceleration": [0, 0, -9.81]}])"};
/// All nodes, by V = (0.5, −0.25, 1.5) m/s, until they stop at 0.2 s.
const Replacement kCarried{"/constraints",
                           R"([{"plugin": "move", "where": {"box": [[-9, -9], [9, 9]]},
      "times": [0, 0.2], "displacements": [[0, 0, 0], [0.1, -0.05, 0.3]]}])"};
constexpr double kSpeed2 = 0.5 * 0.5 + 0.25 * 0.25 + 1.5 * 1.5;  // |V|² [m²/s²]

class Balance : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = (fs::temp_directory_path() / "deform_balance_XXXXXX").string();
    ASSERT_NE(::mkdtemp(name.data()), nullptr);
    folder_ = name;
  }
  void TearDown() override { fs::remove_all(folder_); }

  /// The last row of the probes by header, without units and what the columns begin with.
  std::map<std::string, double> last_row(const std::string& text,
                                         const std::vector<Replacement>& changes) {
    RunOptions options;
    options.folder = folder_ / "run";
    options.force = true;
    const Scene scene = read_scene_text(text, "scene.json", ".", *test::built_in(), changes);
    const RunResult result = run(scene, test::built_in(), options);
    EXPECT_EQ(result.code, ExitCode::done) << result.reason;
    std::map<std::string, double> figures;
    for (const auto& [header, figure] : result.figures) {
      const std::string name = header.substr(0, header.find(' '));
      figures[name.substr(name.find('.') + 1)] = figure;
    }
    return figures;
  }

  fs::path folder_;
};

TEST_F(Balance, OfFreeFallIsTheMethodsErrorInClosedForm) {
  for (const char* integrator : {"semi_implicit", "symplectic_euler"}) {
    for (const double step : {0.01, 0.005}) {
      const auto row = last_row(
          kFree,
          {kFalls, {"/integrator/plugin", integrator}, {"/integrator/step", std::to_string(step)}});
      // v⁺ = v + g dt, r⁺ = r + v⁺ dt: the way is g dt²/2 a step too long.
      const double fall = 0.5 * kGravity * 0.2 * (0.2 + step);
      EXPECT_NEAR(row.at("change"), 0.5 * kMass * std::pow(kGravity * 0.2, 2), 1e-10);
      EXPECT_NEAR(row.at("loads"), kMass * kGravity * fall, 1e-10) << integrator;
      EXPECT_NEAR(row.at("drift"), -0.5 * kMass * kGravity * kGravity * step * 0.2, 1e-10);
      EXPECT_EQ(row.at("constraints"), 0);
      EXPECT_EQ(row.at("damping"), 0);
    }
  }
}

TEST_F(Balance, IsExactWhereNodesAreCarriedAtOneVelocity) {
  const double damping = 2.0 * 1.2 * 0.8;  // [N·s/m]
  const auto row = last_row(kFree, {kFalls, kCarried, {"/material/damping", "2"}});
  const double lost = damping * kSpeed2 * (0.2 - 0.005);  // at rest at the first step's beginning
  EXPECT_NEAR(row.at("damping"), lost, 1e-10);
  EXPECT_NEAR(row.at("loads"), -kMass * kGravity * 0.3, 1e-10);
  EXPECT_NEAR(row.at("constraints"), 0.5 * kMass * kSpeed2 + lost + kMass * kGravity * 0.3, 1e-10);
  EXPECT_NEAR(row.at("drift"), 0, 1e-12);
  EXPECT_NEAR(row.at("relative_drift"), 0, 1e-12);
}

TEST_F(Balance, KnowsWhatConstraintsTakeWhenTheyStop) {
  const auto row = last_row(kFree, {kFalls, kCarried, {"/duration", "0.3"}});
  EXPECT_NEAR(row.at("constraints"), kMass * kGravity * 0.3, 1e-10);
  EXPECT_NEAR(row.at("change"), 0, 1e-10);
  EXPECT_NEAR(row.at("drift"), 0, 1e-12);
}

/// Sides that move a sheet through it: what its energy gains is what they put in, but for the
/// method's error, which is of first order.
TEST_F(Balance, DriftShrinksWithTheStep) {
  const std::string moved = R"([
    {"plugin": "pin", "where": {"boundary": "left"}},
    {"plugin": "move", "where": {"boundary": "right"}, "times": [0, 0.1, 0.2],
     "displacements": [[0, 0, 0], [0.01, 0, 0.05], [-0.01, 0, 0.05]]}])";
  const std::string pinned = R"([{"plugin": "pin", "where": {"boundary": "left"}}])";
  for (const std::string& constraints : {pinned, moved}) {
    std::vector<double> drifts, relative;
    for (const char* step : {"0.001", "0.0005", "0.00025"}) {
      const auto row = last_row(kFree, {kFalls,
                                        {"/constraints", constraints},
                                        {"/material/damping", "1"},
                                        {"/integrator/step", step}});
      drifts.push_back(row.at("drift"));
      relative.push_back(row.at("relative_drift"));
      EXPECT_EQ(row.at("constraints") == 0, constraints == pinned);
      EXPECT_GT(row.at("damping"), 0);
      EXPECT_LT(row.at("drift"), 0);
    }
    for (const int k : {0, 1}) EXPECT_NEAR(drifts[k] / drifts[k + 1], 2, 0.3) << constraints;
    EXPECT_LT(std::abs(relative.back()), 0.05);
  }
}

TEST_F(Balance, DoesNotDependOnWhatIsRecorded) {
  const std::vector<Replacement> scene{
      kFalls, {"/constraints", R"([{"plugin": "pin", "where": {"boundary": "left"}}])"}};
  auto rarely = scene;
  rarely.push_back({"/probes", R"([{"plugin": "energy_balance", "every": 7}, "momentum"])"});
  EXPECT_EQ(last_row(kFree, scene), last_row(kFree, rarely));
}

/// Momentum [kg·m/s] and angular momentum about a point [kg·m²/s].
struct Momenta {
  Vec3 linear = Vec3::Zero(), angular = Vec3::Zero();
};
Momenta momenta(Simulation& s, const Vec3& about) {
  Momenta sum;
  for (Index a = 0; a < s.state().r.rows(); ++a) {
    const Vec3 p = s.system().mass()[a] * s.state().v.row(a).transpose();
    sum.linear += p;
    sum.angular += (Vec3(s.state().r.row(a)) - about).cross(p);
  }
  return sum;
}

TEST_F(Balance, ThrownWithSpinASheetHasTheMomentaOfARigidBody) {
  const Replacement thrown{"/velocity", R"({"linear": [1, -2, 0.5], "spin": [0.3, 0.2, -4]})"};
  Simulation s = test::simulation_from_text(kFree, {thrown});
  const NodeVectors& r = s.state().r;
  const NodeValues& mass = s.system().mass();
  const Vec3 centre = r.transpose() * mass / mass.sum(), spin(0.3, 0.2, -4);
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();
  for (Index a = 0; a < r.rows(); ++a) {
    const Vec3 arm = r.row(a).transpose() - centre;
    inertia += mass[a] * (arm.squaredNorm() * Eigen::Matrix3d::Identity() - arm * arm.transpose());
  }
  const Momenta own = momenta(s, centre), origin = momenta(s, Vec3::Zero());
  const Vec3 p = kMass * Vec3(1, -2, 0.5);
  EXPECT_LE((own.linear - p).norm(), 1e-14);
  EXPECT_LE((own.angular - inertia * spin).norm(), 1e-14);
  EXPECT_LE((origin.angular - (inertia * spin + centre.cross(p))).norm(), 1e-14);

  // No force acts at first: the probe finds the same after a step.
  const auto row = last_row(kFree, {thrown, {"/duration", "0.01"}});
  for (const int c : {0, 1, 2}) {
    EXPECT_NEAR(row.at(std::string("p") + "xyz"[c]), p[c], 1e-12);
    EXPECT_NEAR(row.at(std::string("l") + "xyz"[c]), origin.angular[c], 1e-12);
  }
}

TEST_F(Balance, VelocitiesFollowFormulasWhereNodesAreFree) {
  const Replacement formulas{"/velocity", R"(["a1*a2", 2, "a2^2"])"};
  const Replacement pinned{"/constraints", R"([{"plugin": "pin", "where": {"boundary": "left"}}])"};
  Simulation s = test::simulation_from_text(kFree, {formulas, pinned});
  const Eigen::MatrixX2d& a = s.system().surface().parameters();
  for (Index n = 0; n < a.rows(); ++n) {
    Vec3 expected(a(n, 0) * a(n, 1), 2, a(n, 1) * a(n, 1));
    if (a(n, 0) == 0) expected.setZero();
    EXPECT_LE((s.state().v.row(n).transpose() - expected).norm(), 1e-15) << "node " << n;
  }
}

TEST_F(Balance, SpinTurnsAboutTheGivenPoint) {
  const Replacement spin{"/velocity", R"({"spin": [0, 0, 2], "about": [0.3, -0.2, 7]})"};
  const Simulation s = test::simulation_from_text(kFree, {spin});
  for (Index n = 0; n < s.state().r.rows(); ++n) {
    const Vec3 r = s.state().r.row(n);
    const Vec3 expected(-2 * (r.y() + 0.2), 2 * (r.x() - 0.3), 0);
    EXPECT_LE((s.state().v.row(n).transpose() - expected).norm(), 1e-15) << "node " << n;
  }
}

TEST_F(Balance, VelocitiesOfTheMirroredWorldAreReflected) {
  const Simulation s = test::simulation_from_text(
      kFree, {{"/velocity", R"({"linear": [1, "a1", "2 - a2"], "spin": [3, 2, 1]})"}});
  NodeVectors reflected = s.mirrored()->state().v;
  reflected.col(2) *= -1;
  EXPECT_EQ(reflected, s.state().v);
}

TEST_F(Balance, AVelocityThatIsNotFiniteIsAProblemOfTheScene) {
  try {
    (void)test::simulation_from_text(kFree, {{"/velocity", R"([0, "1/a1", 0])"}});
    ADD_FAILURE() << "it was accepted";
  } catch (const InputError& e) {
    ASSERT_EQ(e.problems().size(), 1U);
    EXPECT_EQ(e.problems()[0].pointer, "/velocity/1");
    EXPECT_EQ(e.problems()[0].message,
              "at /velocity/1: 1/a1 is inf at a1 = 0, a2 = 0, expected a finite number [m/s]");
  }
}

}  // namespace
}  // namespace deform
