// Results belong to whoever asks for them: what was evaluated before changes no bit.
#include <string>
#include <vector>

#include "deform/solve/lagged_matrix.h"
#include "deform/solve/newton_matrix.h"

#include "model/support/random.h"
#include "model/support/simulate.h"

namespace {
using namespace deform;
using test::random_vectors;
using test::simulation_from_text;

/// Jets, tuples, damping of materials, loads that need normals, friction of the air.
constexpr const char* kSheet = R"({
  "surface": {"plugin": "grid", "nodes": [9, 8], "size": [1.0, 0.8]},
  "material": {"density": 0.4, "rayleigh_stiffness": 0.01},
  "energies": [{"plugin": "stretching", "eta": 100},
               {"plugin": "bending_variational", "xi": 0.1},
               {"plugin": "edge_springs", "stiffness": 3}],
  "forces": [{"plugin": "gravity"}, {"plugin": "pressure", "pressure": 2},
             {"plugin": "wind", "velocity": [1, 0.5, 0], "drag": 0.3}],
  "constraints": [{"plugin": "pin", "where": {"corners": ["left_bottom"]}}],
  "integrator": {"plugin": "backward_euler", "step": 0.01}, "duration": 0.1})";

struct Evaluations : ::testing::Test {
  Simulation simulation = simulation_from_text(kSheet);
  const System& system = simulation.system();

  [[nodiscard]] State state(double strain, double time) const {
    const Index n = system.nodes();
    State s = simulation.state();
    s.r += strain * random_vectors(n, 3);
    s.v = 10 * strain * random_vectors(n, 3);
    s.time = time;
    return s;
  }

  /// All that can be asked of a state, by objects that have been asked before.
  std::vector<double> ask(const State& s, const StepStrains* strains) {
    std::vector<double> all;
    const auto add = [&](const auto& values) {
      all.insert(all.end(), values.data(), values.data() + values.size());
    };
    const Evaluator& evaluator = system.evaluator();
    add(evaluator.force(s, strains));
    add(evaluator.nonconservative_force(s, strains));
    add(evaluator.damping_force(s));
    all.push_back(evaluator.potential(s, strains));
    newton.evaluate(s, {.kind = Tangent::projected, .rate = 100, .strains = strains});
    add(newton.matrix().value);
    newton.evaluate(s, {.kind = Tangent::exact, .rate = 100, .strains = strains});
    add(newton.matrix().value);
    NodeVectors f;
    lagged.evaluate(s, f);
    add(f);
    add(lagged.matrix().value);
    for (std::size_t t = 0; t < system.energies().size(); ++t) {
      add(system.terms().energy_density(t, s.r));
      add(system.terms().internal_force(t, s));
      all.push_back(system.terms().energy(t, s));
    }
    add(system.terms().external_force(s));
    return all;
  }

  NewtonMatrix newton{system};
  LaggedMatrix lagged{system};
};

TEST_F(Evaluations, OfTwoStatesShareNothing) {
  const State a = state(0.01, 0), b = state(0.03, 0.05);
  const std::vector<double> first = ask(a, nullptr);
  const std::vector<double> other = ask(b, nullptr);
  EXPECT_NE(first, other);
  EXPECT_EQ(ask(a, nullptr), first);
  EXPECT_EQ(ask(b, nullptr), other);
  EXPECT_EQ(ask(b, nullptr), other);
}

TEST_F(Evaluations, OfStrainsOverAStepShareNothingWithThoseOfAState) {
  const State start = state(0.01, 0), a = state(0.02, 0.01);
  StepStrains mean, rates;
  mean.average_from(system.evaluator(), start.r);
  rates.measure_rates_from(system.evaluator(), 100, start.r, -0.3, a.r);
  const std::vector<double> alone = ask(a, nullptr), of_mean = ask(a, &mean),
                            of_rates = ask(a, &rates);
  EXPECT_NE(alone, of_mean);
  EXPECT_NE(alone, of_rates);
  EXPECT_EQ(ask(a, &rates), of_rates);
  EXPECT_EQ(ask(a, nullptr), alone);
  EXPECT_EQ(ask(a, &mean), of_mean);
  mean.reset();
  EXPECT_EQ(ask(a, &mean), alone);
}

TEST_F(Evaluations, GeometryStaysWhatItIsWhileSomebodyHoldsIt) {
  const SampleSet& samples = system.surface().samples(SampleRole::bending);
  const State a = state(0.01, 0);
  const auto held = system.terms().geometry(a.r, samples);
  const double B = held->all().B(Pair::p11)[3];
  std::vector<std::shared_ptr<const Geometry>> others;
  for (int i = 1; i < 6; ++i) {
    (void)system.evaluator().force(state(0.01 * i, 0));
    others.push_back(system.terms().geometry(state(0.02 * i, 0).r, samples));
  }
  EXPECT_EQ(held->all().B(Pair::p11)[3], B);
  EXPECT_EQ(system.terms().geometry(a.r, samples), held);
}

}  // namespace
