/// Multigrid: coarser nodes, systems solved as factorisations solve them, work that does not grow.
#include <fmt/format.h>

#include "deform/solve/newton_matrix.h"

#include "model/support/random.h"
#include "model/support/simulate.h"

namespace deform {
namespace {

using test::random_vectors;
using test::simulation_from_text;
using test::simulation_of;

/// A sheet that is let go; the rest of the scene in pieces of JSON.
std::string sheet(const std::string& surface, const std::string& integrator,
                  const std::string& more = "") {
  return fmt::format(R"({{
    "surface": {{"plugin": "grid", {}}},
    "material": {{"density": 0.2}},
    "energies": [{{"plugin": "koiter", "young": 1e6, "poisson": 0.3, "thickness": 1e-3}}],
    "forces": [{{"plugin": "gravity"}}],
    "constraints": [{{"plugin": "pin", "where": {{"corners": ["left_bottom", "left_top"]}}}}],
    "integrator": {{"plugin": {}, "step": 0.01}}, "duration": 0.1{}}})",
                     surface, integrator, more);
}

NodeVectors end_of(const std::string& scene) {
  Simulation simulation = simulation_from_text(scene);
  const auto diverged = test::run_to_end(simulation);
  EXPECT_FALSE(diverged) << diverged->what();
  return simulation.state().r;
}

struct Shape {
  std::string name, surface;
};
std::ostream& operator<<(std::ostream& out, const Shape& shape) { return out << shape.name; }

/// Of the fine nodes that are coarse ones.
Eigen::MatrixX2d coarse_parameters(const Prolongation& linear, const Eigen::MatrixX2d& fine) {
  Eigen::MatrixX2d coarse(linear.coarse, 2);
  for (Index a = 0; a < fine.rows(); ++a)
    if (const auto q = linear.begin[static_cast<std::size_t>(a)];
        linear.begin[static_cast<std::size_t>(a) + 1] == q + 1)
      coarse.row(linear.node[static_cast<std::size_t>(q)]) = fine.row(a);
  return coarse;
}

void expect_parameters(const Surface& surface, const Prolongation& p,
                       const Eigen::MatrixX2d& coarse, const Eigen::MatrixX2d& fine) {
  for (Index a = 0; a < fine.rows(); ++a) {
    Vec2 sum = Vec2::Zero(), least = fine.row(a), most = least;
    for (auto q = static_cast<std::size_t>(p.begin[static_cast<std::size_t>(a)]);
         q < static_cast<std::size_t>(p.begin[static_cast<std::size_t>(a) + 1]); ++q) {
      const Vec2 at = coarse.row(p.node[q]);
      sum += p.weight[q] * at;
      least = least.cwiseMin(at), most = most.cwiseMax(at);
    }
    for (int k = 0; k < 2; ++k) {
      const bool wraps = surface.period()[k] > 0 && most[k] - least[k] > surface.period()[k] / 2;
      if (!wraps) {
        EXPECT_NEAR(sum[k], fine(a, k), 1e-12);
      }
    }
  }
}

class Coarsening : public testing::TestWithParam<Shape> {};

/// Interpolated linear functions of the parameters are exact, but across a joined side.
TEST_P(Coarsening, KeepsLinearFunctions) {
  Simulation simulation = simulation_from_text(
      fmt::format(R"({{"surface": {{"plugin": "grid", {}}}, "material": {{"density": 1}},
        "integrator": {{"plugin": "symplectic_euler", "step": 0.01}}, "duration": 0.01}})",
                  GetParam().surface));
  const Surface& surface = simulation.system().surface();
  const std::vector<Prolongation> linear = surface.coarsening(),
                                  smooth = surface.smooth_coarsening();
  ASSERT_EQ(linear.size(), smooth.size());
  Eigen::MatrixX2d fine = surface.parameters();
  for (std::size_t l = 0; l < linear.size(); ++l) {
    const Eigen::MatrixX2d coarse = coarse_parameters(linear[l], fine);
    expect_parameters(surface, linear[l], coarse, fine);
    expect_parameters(surface, smooth[l], coarse, fine);
    fine = coarse;
  }
  EXPECT_LE(fine.rows(), 30);
}

INSTANTIATE_TEST_SUITE_P(
    Grids, Coarsening,
    testing::Values(Shape{"powers_of_two", R"("nodes": [33, 33])"},
                    Shape{"even", R"("nodes": [20, 26], "size": [1, 1.3])"},
                    Shape{"a_strip", R"("nodes": [200, 5], "size": [40, 1])"},
                    Shape{"flat_cells", R"("nodes": [40, 40], "size": [1, 8])"},
                    Shape{"a_cylinder", R"("nodes": [24, 13], "periodic": [true, false],
                          "rest": {"plugin": "arc", "radius": 0.15915494309189535})"},
                    Shape{"an_odd_cylinder", R"("nodes": [25, 13], "periodic": [true, false],
                          "rest": {"plugin": "arc", "radius": 0.15915494309189535})"}),
    [](const auto& shape) { return shape.param.name; });

/// The second differences of u at nodes inside.
double bending_of(const Eigen::VectorXd& u) {
  const Index n = u.size() - 2;
  return (u.head(n) - 2 * u.segment(1, n) + u.tail(n)).squaredNorm();
}

/// A parabola's second derivative is the same on all levels: interpolated smoothly, its energy is,
/// too, but for the ends; linearly it doubles each time.
TEST(SmoothCoarsening, KeepsTheEnergyOfBending) {
  Simulation simulation = simulation_from_text(
      R"({"surface": {"plugin": "grid", "nodes": [129, 5], "size": [128, 4]},
          "material": {"density": 1},
          "integrator": {"plugin": "symplectic_euler", "step": 0.01}, "duration": 0.01})");
  const Surface& surface = simulation.system().surface();
  const auto energy = [](const Prolongation& p) {
    const Index coarse = p.coarse / 5;
    Eigen::VectorXd u(129);
    for (std::size_t a = 0; a < 129; ++a) {
      u[static_cast<Index>(a)] = 0;
      for (auto q = static_cast<std::size_t>(p.begin[a]);
           q < static_cast<std::size_t>(p.begin[a + 1]); ++q) {
        const double x = 2.0 * (p.node[q] % static_cast<std::int32_t>(coarse));
        u[static_cast<Index>(a)] += p.weight[q] * x * x / 2;
      }
    }
    return bending_of(u);
  };
  EXPECT_NEAR(energy(surface.smooth_coarsening().front()), 127, 3);
  EXPECT_NEAR(energy(surface.coarsening().front()), 254, 3);
}

/// Steps that may take so many iterations each.
TEST(Multigrid, TakesAsManyIterationsForBendingOnFineGrids) {
  for (const int nodes : {65, 129, 193}) {
    Simulation simulation =
        simulation_of("benchmarks/sheet_p.json", "base",
                      {{"/surface/nodes", fmt::format("[{0}, {0}]", nodes)},
                       {"/duration", "0.1"},
                       {"/integrator/tolerance", "1e-4"},
                       {"/solver", R"({"plugin": "multigrid", "iterations": 9})"},
                       {"/energies/1", R"({"plugin": "bending_variational", "xi": 1e-3})"}});
    const auto diverged = test::run_to_end(simulation);
    EXPECT_FALSE(diverged) << nodes << ": " << diverged->what();
  }
}

/// The tangent of a sheet at rest and its masses, for steps of 0.01 s: what an implicit step solves
/// with. The iterations that reduce a random error to 1e-5.
long iterations_at(int nodes) {
  Simulation simulation =
      simulation_from_text(sheet(fmt::format(R"("nodes": [{0}, {0}])", nodes),
                                 R"("backward_euler")", R"(, "solver": {"plugin": "multigrid"})"));
  System& system = simulation.system();
  State state{system.rest(), NodeVectors::Zero(system.nodes(), 3), 0};
  NewtonMatrix tangent(system);
  tangent.evaluate(state, {.kind = Tangent::projected});
  const NodeValues inertia = system.mass() / 1e-4;
  NodeVectors b = random_vectors(system.nodes(), 3), x, product;
  system.constraints().reduce_force(b);
  EXPECT_EQ(tangent.solve_to(1e-5, inertia, b, x), "");
  tangent.matrix().multiply(x, product);
  product += inertia.asDiagonal() * x;
  system.constraints().reduce_force(product);
  EXPECT_LT((product - b).norm(), 1e-3 * b.norm());
  return tangent.solver_iterations();
}

TEST(Multigrid, TakesAsManyIterationsOnFineGrids) {
  const long coarse = iterations_at(33), fine = iterations_at(129);
  EXPECT_GT(coarse, 0);
  EXPECT_LE(fine, coarse + 6);
  EXPECT_LE(fine, 24);
}

TEST(Multigrid, IsChosenForLargeSurfaces) {
  const auto choice_at = [](int nodes) {
    Simulation simulation = simulation_from_text(
        sheet(fmt::format(R"("nodes": [{0}, {0}])", nodes), R"("backward_euler")"));
    simulation.step();
    return simulation.system().step_report().solver_iterations;
  };
  EXPECT_EQ(choice_at(21), 0);
  EXPECT_GT(choice_at(41), 0);
}

TEST(Multigrid, NewtonStepsEndAsWithAFactorisation) {
  const std::string surface = R"("nodes": [34, 41])";
  const NodeVectors exact = end_of(
      sheet(surface, R"("bdf2", "tolerance": 1e-9)", R"(, "solver": {"plugin": "cholmod"})"));
  const NodeVectors iterative = end_of(
      sheet(surface, R"("bdf2", "tolerance": 1e-9)", R"(, "solver": {"plugin": "multigrid"})"));
  EXPECT_LT((iterative - exact).cwiseAbs().maxCoeff(), 1e-8);
}

TEST(Multigrid, LaggedStepsEndAsWithAFactorisation) {
  const auto end = [&](const std::string& solver, const std::string& tolerance = "1e-9") {
    Simulation simulation =
        simulation_of("benchmarks/sheet_p.json", "base",
                      {{"/surface/nodes", "[33, 40]"},
                       {"/integrator/tolerance", tolerance},
                       {"/solver", fmt::format(R"({{"plugin": "{}"}})", solver)},
                       {"/energies/1", R"({"plugin": "bending_variational", "xi": 1e-6})"}});
    EXPECT_FALSE(test::run_to_end(simulation));
    return simulation.state().r;
  };
  const NodeVectors exact = end("cholmod");
  EXPECT_LT((end("multigrid") - exact).cwiseAbs().maxCoeff(), 1e-8);
  // By default each change of the velocity is found to 1e-6.
  EXPECT_LT((end("multigrid", "1e-6") - exact).cwiseAbs().maxCoeff(), 1e-6);
}

/// What acts in a step may be small beside the momentum: v falls by γ dt/ρ a step, of (ρ/dt − γ/2)
/// over (ρ/dt + γ/2), whatever the solver.
TEST(Multigrid, LaggedStepsDampSlowlyWithSmallSteps) {
  constexpr double kDensity = 0.1, kDamping = 0.2, kStep = 1e-7, kSpeed = 10;
  for (const std::string solver : {"cholmod", "multigrid", "bicgstab"}) {
    Simulation simulation = simulation_from_text(fmt::format(
        R"({{"surface": {{"plugin": "grid", "nodes": [33, 33]}},
             "material": {{"density": {}, "damping": {}}},
             "energies": [{{"plugin": "stretching", "eta": 100}}],
             "velocity": [0, 0, {}], "solver": {{"plugin": "{}"}},
             "integrator": {{"plugin": "semi_implicit", "step": {}}}, "duration": {}}})",
        kDensity, kDamping, kSpeed, solver, kStep, 100 * kStep));
    ASSERT_FALSE(test::run_to_end(simulation)) << solver;
    const double inertia = kDensity / kStep, drag = kDamping / 2;
    const double lost = kSpeed * (1 - std::pow((inertia - drag) / (inertia + drag), 100));
    const auto z = simulation.state().v.col(2);
    EXPECT_NEAR((kSpeed - z.array()).maxCoeff(), lost, 1e-6 * lost) << solver;
    EXPECT_NEAR((kSpeed - z.array()).minCoeff(), lost, 1e-6 * lost) << solver;
  }
}

/// What Newton's method may leave is what it leaves, at most.
TEST(Multigrid, NewtonErrorIsKept) {
  for (const std::string integrator : {"backward_euler", "bdf2", "implicit_midpoint"}) {
    const std::string surface = R"("nodes": [41, 41])";
    const NodeVectors exact =
        end_of(sheet(surface, fmt::format(R"("{}", "tolerance": 1e-9)", integrator)));
    for (const double error : {1e-4, 1e-5}) {
      const NodeVectors quick =
          end_of(sheet(surface, fmt::format(R"("{}", "newton_error": {})", integrator, error)));
      const double left = std::sqrt((quick - exact).rowwise().squaredNorm().mean());
      EXPECT_LT(left, 10 * error) << integrator;  // of ten steps
      EXPECT_GT(left, 0);
    }
  }
}

}  // namespace
}  // namespace deform
