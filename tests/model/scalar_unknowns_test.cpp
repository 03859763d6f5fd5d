// Unknowns beside the nodes' positions: a hidden elongation for each edge.
#include <filesystem>
#include <string>
#include <vector>

#include "deform/check/mechanics.h"
#include "deform/record/trajectory.h"
#include "deform/simulation/run.h"

#include "model/support/simulate.h"

namespace {
using namespace deform;

constexpr double kStiffness = 300, kHidden = 200;

/// A net that falls, pinned at two corners; in statics it hangs in its plane.
std::string net(const std::string& energy, const std::string& integrator) {
  const bool is_static = integrator.find("static") != std::string::npos;
  return R"({"surface": {"plugin": "grid", "nodes": [5, 4], "size": [1.0, 0.75]},
    "material": {"density": 0.5, "damping": 0.2}, "energies": [)" +
         energy + R"(], "forces": [{"plugin": "gravity")" +
         (is_static ? R"(, "acceleration": [0, -9.81, 0])" : "") + R"(}],
    "constraints": [{"plugin": "pin", "where": )" +
         (is_static ? R"({"boundary": ["top"]})" : R"({"corners": ["left_top", "right_top"]})") +
         R"(}], "integrator": {"plugin": )" + integrator + R"(, "step": 0.01}, "duration": 0.4})";
}

std::string hidden(const std::string& more = "") {
  return R"({"plugin": "hidden_springs", "stiffness": 300, "hidden": 200)" + more + "}";
}

/// Both in series.
const std::string kSprings = R"({"plugin": "edge_springs", "stiffness": 120, "diagonals": false})";

Simulation simulation_of(const std::string& scene) {
  static const auto registry = std::make_shared<const PluginRegistry>(
      std::vector<std::filesystem::path>{DEFORM_PLUGINS, DEFORM_FIXTURE_PLUGINS});
  return {read_scene_text(scene, "test scene", ".", *registry, {}), registry};
}

TEST(ScalarUnknowns, AreRowsBehindTheNodes) {
  Simulation s = simulation_of(net(hidden(R"(, "initial": 0.125)"), R"("bdf2")"));
  const System& system = s.system();
  EXPECT_EQ(system.nodes(), 20);
  EXPECT_EQ(system.rows(), 20 + 31);  // 4·4 + 5·3 edges
  EXPECT_EQ(s.state().r.rows(), system.rows());
  for (Index a = system.nodes(); a < system.rows(); ++a)
    EXPECT_EQ(s.state().r.row(a), Eigen::RowVector3d(0.125, 0, 0));
}

TEST(ScalarUnknowns, ForceAndTangentAreDerivatives) {
  Simulation s = simulation_of(net(hidden(), R"("bdf2")"));
  const State state = disturbed(s.system(), 0.02);
  EXPECT_LT(gradient_error(s.system(), 0, state), 1e-7);
  EXPECT_LT(tangent_error(s.system(), state), 1e-6);
  EXPECT_LT(tangent_indefiniteness(s.system(), state, Tangent::projected), 1e-10);
}

/// Without mass they are where forces on them balance: s = k (|e| − L0)/(k + c), and what they are
/// part of is a spring of k c/(k + c).
void expect_series(const std::string& integrator, double tolerance) {
  Simulation s = simulation_of(net(hidden(), integrator));
  Simulation springs = simulation_of(net(kSprings, integrator));
  while (s.steps() < s.scene().steps()) {
    s.step();
    springs.step();
    EXPECT_EQ(s.system().step_report().rejected, 0);
  }
  const Index n = s.system().nodes();
  EXPECT_LT((s.state().r.topRows(n) - springs.state().r).norm(), tolerance);
  const NodeVectors force = s.system().terms().internal_force(0, s.state());
  for (Index a = n; a < s.system().rows(); ++a) EXPECT_NEAR(force(a, 0), 0, 1e-6);
}

TEST(ScalarUnknowns, WithoutMassAreInBalanceInStatics) { expect_series(R"("static")", 1e-8); }
TEST(ScalarUnknowns, WithoutMassAreInBalanceInDynamics) {
  expect_series(R"("bdf2", "tolerance": 1e-10)", 1e-6);
  expect_series(R"("backward_euler", "tolerance": 1e-10)", 1e-6);
}

TEST(ScalarUnknowns, GoOnFromWhatWasSaved) {
  for (const char* mass : {"0", "0.01"})
    for (const char* integrator : {"bdf2", "implicit_midpoint", "static"}) {
      const std::string scene =
          net(hidden(std::string(R"(, "mass": )") + mass), '"' + std::string(integrator) + '"');
      Simulation s = simulation_of(scene), resumed = simulation_of(scene);
      for (int i = 0; i < 10; ++i) s.step();
      Memory memory;
      s.save(memory);
      resumed.load(memory);
      for (int i = 0; i < 10; ++i) {
        s.step();
        resumed.step();
        EXPECT_EQ(s.state().r, resumed.state().r) << integrator;
        EXPECT_EQ(s.state().v, resumed.state().v) << integrator;
      }
    }
}

TEST(ScalarUnknowns, AreInTrajectories) {
  const auto folder = std::filesystem::temp_directory_path() / "deform_scalar_unknowns";
  std::filesystem::remove_all(folder);
  static const auto registry = std::make_shared<const PluginRegistry>(
      std::vector<std::filesystem::path>{DEFORM_PLUGINS, DEFORM_FIXTURE_PLUGINS});
  const std::string text = net(hidden(R"(, "initial": 0.125)"), R"("bdf2")");
  const Scene scene = read_scene_text(text, "test scene", ".", *registry, {});
  RunOptions options;
  options.folder = folder;
  EXPECT_EQ(run(scene, registry, options).code, ExitCode::done);
  Simulation s(scene, registry);
  const Index nodes = s.system().nodes();
  const Trajectory trajectory(folder / kTrajectoryFile);
  for (std::size_t frame = 0; frame < trajectory.frames(); ++frame) {
    while (s.steps() < trajectory.moments()[frame].step) s.step();
    EXPECT_EQ(trajectory.scalars(frame), s.state().r.col(0).tail(31));
    EXPECT_EQ(trajectory.positions(frame), s.state().r.topRows(nodes));
  }
  EXPECT_EQ(trajectory.frames(), 41U);
  std::filesystem::remove_all(folder);
}

TEST(ScalarUnknowns, WithMassSwing) {
  Simulation s = simulation_of(net(hidden(R"(, "mass": 0.01)"), R"("implicit_midpoint")"));
  Simulation fine = simulation_of(net(hidden(R"(, "mass": 0.01)"), R"("runge_kutta")"));
  // Their frequency is √((k + c)/m) = 224 /s: 2 steps a radian.
  while (fine.steps() < 10) fine.step();
  while (s.steps() < 10) s.step();
  EXPECT_LT((s.state().r - fine.state().r).norm(), 0.1);
  EXPECT_GT(fine.state().v.bottomRows(31).norm(), 1e-3);
}

TEST(ScalarUnknowns, WithoutMassTakeAnImplicitIntegrator) {
  for (const char* integrator : {"symplectic_euler", "runge_kutta", "semi_implicit"}) try {
      (void)simulation_of(net(hidden(), '"' + std::string(integrator) + '"'));
      ADD_FAILURE() << integrator;
    } catch (const InputError& e) {
      EXPECT_NE(std::string(e.what()).find("scalar unknown without mass"), std::string::npos);
    }
}

}  // namespace
