// Newton's method, its matrix and its solvers.
#include "deform/solve/newton.h"

#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include <Eigen/Dense>

#include "deform/log.h"
#include "deform/solve/newton_matrix.h"

#include "model/support/random.h"
#include "model/support/simulate.h"

namespace {
using namespace deform;
using test::random_vectors;
using test::simulation_from_text;

constexpr const char* kSheet = R"({
  "surface": {"plugin": "grid", "nodes": [6, 5], "size": [1.0, 0.8]},
  "material": {"density": 0.4, "damping": 0.5},
  "energies": [{"plugin": "koiter", "young": 1e5, "poisson": 0.3, "thickness": 0.01}],
  "forces": [{"plugin": "gravity"}],
  "constraints": [{"plugin": "pin", "where": {"boundary": ["left"]}}],
  "integrator": {"plugin": "backward_euler", "step": 0.01}, "duration": 0.1})";

Eigen::MatrixXd dense(const BlockMatrix& k) {
  Eigen::MatrixXd full(3 * k.nodes, 3 * k.nodes);
  NodeVectors x = NodeVectors::Zero(k.nodes, 3), y;
  for (Index j = 0; j < 3 * k.nodes; ++j) {
    x(j / 3, j % 3) = 1;
    k.multiply(x, y);
    for (Index i = 0; i < 3 * k.nodes; ++i) full(i, j) = y(i / 3, i % 3);
    x(j / 3, j % 3) = 0;
  }
  return full;
}

/// A penalty between a node and a face that it is not part of: four nodes, none of which need be
/// neighbours.
std::vector<BlockEntry> node_and_face(double stiffness) {
  const std::array<Index, 4> nodes{29, 0, 1, 7};
  const std::array<double, 4> weight{1, -0.2, -0.3, -0.5};
  const Vec3 n = Vec3(1, 2, 3).normalized();
  std::vector<BlockEntry> entries;
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t j = i; j < 4; ++j)
      entries.push_back(
          {nodes[i], nodes[j], stiffness * weight[i] * weight[j] * n * n.transpose()});
  return entries;
}

TEST(NewtonMatrix, TakesBlocksBetweenAnyNodes) {
  for (const char* solver : {"cholmod", "multigrid"}) {
    Simulation s = simulation_from_text(
        kSheet, {{"/solver", std::string(R"({"plugin": ")") + solver + R"("})"}});
    const System& system = s.system();
    State state = s.state();
    state.r += 0.01 * random_vectors(system.nodes(), 1);
    NewtonMatrix matrix(system);
    matrix.evaluate(state, {.kind = Tangent::projected, .for_directions = true});
    const Eigen::MatrixXd before = dense(matrix.matrix());
    const NodeValues d = NodeValues::Constant(system.nodes(), 50);
    for (const double stiffness : {1e3, 2e3}) {
      matrix.evaluate(state, {.kind = Tangent::projected, .for_directions = true});
      matrix.add(node_and_face(stiffness));
      Eigen::MatrixXd expected = before;
      for (const BlockEntry& e : node_and_face(stiffness)) {
        expected.block<3, 3>(3 * e.a, 3 * e.b) += e.block;
        if (e.a != e.b) expected.block<3, 3>(3 * e.b, 3 * e.a) += e.block.transpose();
      }
      const Eigen::MatrixXd found = dense(matrix.matrix());
      EXPECT_LT((found - expected).norm(), 1e-13 * expected.norm());

      const NodeVectors b = random_vectors(system.nodes(), 2);
      NodeVectors x;
      ASSERT_EQ(matrix.solve_to(1e-6, d, b, x), "") << solver;
      NodeVectors product;
      matrix.matrix().multiply(x, product);
      for (int c = 0; c < 3; ++c) product.col(c) += d.cwiseProduct(x.col(c));
      NodeVectors left = product - b;
      system.constraints().reduce_force(left);
      EXPECT_LT(left.norm(), 1e-3 * b.norm()) << solver;
    }
    matrix.evaluate(state, {.kind = Tangent::projected});
    EXPECT_LT((dense(matrix.matrix()) - before).norm(), 1e-13 * before.norm());
  }
}

/// An equilibrium whose steps are capped, and which sees to it that they are.
class Capped final : public Objective {
 public:
  Capped(const System& system, double cap) : system_(&system), matrix_(system), cap_(cap) {}

  [[nodiscard]] bool has_potential() const override { return true; }
  [[nodiscard]] double merit(State& state) override {
    see(state);
    return system_->evaluator().potential(state);
  }
  [[nodiscard]] double evaluate(State& state, Tangent kind, const NodeVectors& before) override {
    matrix_.evaluate(state, {.kind = before.rows() > 0 ? kind : Tangent::exact,
                             .before = before.rows() > 0 ? &before : nullptr});
    return evaluate_residual(state);
  }
  [[nodiscard]] double evaluate_residual(State& state) override {
    see(state);
    system_->evaluator().force(state, force_);
    scale_ = force_.norm();
    system_->constraints().reduce_force(force_);
    from_ = state.r;
    return force_.norm();
  }
  [[nodiscard]] double scale() const override { return scale_; }
  [[nodiscard]] std::string find_direction(State& /*state*/, double /*tolerance*/,
                                           Tangent& /*kind*/, NodeVectors& direction) override {
    const std::string reason = matrix_.factor(NodeValues::Zero(system_->nodes()));
    return reason.empty() ? matrix_.solve(force_, direction) : reason;
  }
  [[nodiscard]] std::string find_direction_again(double /*tolerance*/,
                                                 NodeVectors& direction) override {
    return matrix_.solve(force_, direction);
  }
  [[nodiscard]] double slope(const NodeVectors& direction) const override {
    return -force_.cwiseProduct(direction).sum();
  }
  [[nodiscard]] double step_limit(const Path& path) override { return cap_ / path.length(); }
  [[nodiscard]] double characteristic_length() const override { return 1; }

  double farthest = 0;  // that a node was moved from the last evaluation [m]

 private:
  void see(const State& state) {
    if (from_.rows() > 0)
      farthest = std::max(farthest, (state.r - from_).rowwise().norm().maxCoeff());
  }

  const System* system_;
  NewtonMatrix matrix_;
  double cap_, scale_ = 0;
  NodeVectors force_, from_;
};

TEST(Newton, StaysWithinTheLongestStep) {
  // Pinned all around: its rest state is stable.
  Simulation s = simulation_from_text(
      kSheet,
      {{"/constraints",
        R"([{"plugin": "pin", "where": {"boundary": ["left", "right", "top", "bottom"]}}])"}});
  const double merit = s.system().evaluator().potential(s.state());
  std::vector<NodeVectors> solutions;
  for (const double cap : {kInfinity, 0.02}) {
    Capped objective(s.system(), cap);
    Newton newton(s.system());
    State state = s.state();
    StepReport report;
    const NewtonSettings settings{.tolerance = 1e-10, .iterations = 200, .rotates = false};
    EXPECT_EQ(newton.solve(objective, settings, merit, state, report), "");
    solutions.push_back(state.r);
    if (cap < kInfinity) {
      EXPECT_LE(objective.farthest, cap * (1 + 1e-9));
      EXPECT_GT(objective.farthest, 0.5 * cap);
    }
  }
  EXPECT_LT((solutions[0] - solutions[1]).norm(), 1e-6 * solutions[0].norm());
}

TEST(SolverChain, AFailingSolverHalvesNothing) {
  const auto with_cannot = std::make_shared<const PluginRegistry>(
      std::vector<std::filesystem::path>{DEFORM_PLUGINS, DEFORM_FIXTURE_SOLVERS});
  for (const char* integrator : {"backward_euler", "implicit_midpoint", "bdf2", "semi_implicit"}) {
    const std::vector<Replacement> changes{
        {"/integrator/plugin", '"' + std::string(integrator) + '"'}, {"/integrator/step", "0.001"}};
    Simulation alone = simulation_from_text(kSheet, changes);
    Simulation s(read_scene_text(kSheet, "test scene", ".", *with_cannot, changes), with_cannot);
    testing::internal::CaptureStderr();
    for (int i = 0; i < 10; ++i) {
      alone.step();
      s.step();
      EXPECT_EQ(s.system().step_report().rejected, 0) << integrator;
    }
    const std::string log = testing::internal::GetCapturedStderr();
    EXPECT_EQ(alone.state().r, s.state().r) << integrator;
    const std::string message = "solver cannot hands over to";
    const std::size_t first = log.find(message);
    EXPECT_NE(first, std::string::npos) << integrator << log;
    EXPECT_EQ(log.find(message, first + 1), std::string::npos) << integrator << log;
  }
}

}  // namespace
