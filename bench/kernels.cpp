/// The kernels of a Newton step of the hanging sheet, each with the bytes that must move (what it
/// is given and what it makes, each once) and the floating point operations of its inner loops.
#include <memory>
#include <string>
#include <vector>

#include <benchmark/benchmark.h>
#include <tbb/global_control.h>

#include "deform/simulation/simulation.h"
#include "deform/solve/newton_matrix.h"

namespace {
using namespace deform;

std::shared_ptr<const PluginRegistry> built_in() {
  static const auto registry = std::make_shared<const PluginRegistry>();
  return registry;
}

/// The sheet a little way down, and states nearby: two geometries are remembered, of three none is
/// the one asked for.
struct Hanging {
  explicit Hanging(std::int64_t n) : simulation(scene(n), built_in()) {
    for (int i = 0; i < 3; ++i) simulation.step();
    for (int i = 0; i < 3; ++i) {
      states[i] = simulation.state();
      states[i].r += 1e-4 * i * states[i].v;
    }
  }
  static Scene scene(std::int64_t n) {
    const std::string side = std::to_string(n);
    const std::vector<Replacement> changes{
        {"/surface/nodes", "[" + side + ", " + side + "]"},
        {"/integrator", R"({"plugin": "backward_euler", "step": 0.01, "newton_error": 1e-4})"},
        {"/probes", "[]"}};
    return read_scene(std::string(DEFORM_BENCHMARK_SCENES) + "/hanging_sheet.json", *built_in(),
                      changes);
  }
  State& next() { return states[++turn % 3]; }
  System& system() { return simulation.system(); }

  Simulation simulation;
  State states[3];
  std::size_t turn = 0;
};

const TangentRequest kForDirections{.kind = Tangent::projected, .for_directions = true};

struct Sizes {
  double membrane = 0, bending = 0;  ///< samples
  double blocks = 0;                 ///< of the tangent
  double nodes = 0;
};
Sizes sizes_of(Hanging& h) {
  Sizes s;
  s.nodes = static_cast<double>(h.system().nodes());
  const auto samples = [&](SampleRole role) {
    return static_cast<double>(h.system().surface().samples(role).size());
  };
  s.membrane = samples(SampleRole::membrane), s.bending = samples(SampleRole::bending);
  NewtonMatrix tangent(h.system());
  s.blocks = static_cast<double>(tangent.matrix().column.size());
  return s;
}

constexpr double kPosition = 24;  // bytes
/// Of a sample's rest state, as an isotropic term needs them: G⁰ or B⁰, its reciprocal, √det G⁰,
/// the stiffness: eight numbers.
constexpr double kRest = 64;
constexpr double kBlock3 = 36;  // of a 3 × 3 block in single precision
/// Of the coarse levels' matrices together, relative to the finest's.
constexpr double kCoarse = 1.0 / 3;

/// Of gathering second derivatives into rows: Σ_mn D_mᵀ A h_mn D_n, nine entries, a multiplication
/// and an addition each.
double gather_flops(const SampleSet& set, const std::vector<int>& derivatives) {
  double flops = 0;
  for (Index s = 0; s < set.size(); ++s) {
    const SampleSet::Stencil at = set.stencil(s);
    const auto count = [&](std::size_t k) {
      double n = 0;
      for (const int d : derivatives) n += at.d[k][static_cast<std::size_t>(d)] != 0 ? 1 : 0;
      return n;
    };
    for (std::size_t a = 0; a < at.nodes.size(); ++a) {
      flops += 18 * count(a) * static_cast<double>(derivatives.size());
      for (std::size_t b = 0; b < at.nodes.size(); ++b)
        if (at.nodes[b] >= at.nodes[a]) flops += 18 * count(b);
    }
  }
  return flops;
}

void count(benchmark::State& bench, double bytes, double flops) {
  bench.counters["bytes"] = bytes;
  bench.counters["flops"] = flops;
}

/// range(0): nodes a side; range(1): threads.
tbb::global_control limit(const benchmark::State& bench) {
  return {tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(bench.range(1))};
}

void geometry(benchmark::State& bench) {
  const auto threads = limit(bench);
  Hanging h(bench.range(0));
  for (auto _ : bench)
    (void)h.system().terms().geometry(h.next().r,
                                      h.system().surface().samples(SampleRole::bending));
  const Sizes s = sizes_of(h);
  // Written for each sample: r_1, r_2 and G of the membrane, everything of bending.
  count(bench, kPosition * s.nodes + 8 * (9 * s.membrane + GeometryBlock::kFields * s.bending), 0);
}

void geometry_and_force(benchmark::State& bench) {
  const auto threads = limit(bench);
  Hanging h(bench.range(0));
  NodeVectors f;
  for (auto _ : bench) h.system().evaluator().force(h.next(), f);
  const Sizes s = sizes_of(h);
  count(bench, 2 * kPosition * s.nodes + kRest * (s.membrane + s.bending), 0);
}

void geometry_force_and_tangent(benchmark::State& bench) {
  const auto threads = limit(bench);
  Hanging h(bench.range(0));
  NewtonMatrix tangent(h.system());
  NodeVectors f;
  for (auto _ : bench) {
    const State& state = h.next();
    h.system().evaluator().force(state, f);
    tangent.evaluate(state, kForDirections);
  }
  const Sizes s = sizes_of(h);
  const Surface& surface = h.system().surface();
  count(bench, 2 * kPosition * s.nodes + kRest * (s.membrane + s.bending) + kBlock3 * s.blocks,
        gather_flops(surface.samples(SampleRole::membrane), {1, 2}) +
            gather_flops(surface.samples(SampleRole::bending), {1, 2, 3, 4, 5}));
}

/// The solver's matrix is the upper half; on its coarse levels the cycle makes two passes.
void solve(benchmark::State& bench) {
  const auto threads = limit(bench);
  Hanging h(bench.range(0));
  System& system = h.system();
  const State& state = h.next();
  NewtonMatrix tangent(system);
  tangent.evaluate(state, kForDirections);
  const NodeValues inertia = system.mass() / 1e-4;
  const NodeVectors b = system.evaluator().force(state);
  NodeVectors x;
  if (const std::string reason = tangent.solve_to(0.02, inertia, b, x); !reason.empty())
    return bench.SkipWithError(reason.c_str());
  long iterations = 0;
  system.begin_step();
  for (auto _ : bench) {
    (void)tangent.solve_again(1e-4, b, x);
    iterations += tangent.solver_iterations();
  }
  const double each = static_cast<double>(iterations) / static_cast<double>(bench.iterations());
  const Sizes s = sizes_of(h);
  constexpr double kPasses = 1 + 2 * kCoarse;
  bench.counters["iterations"] = each;
  count(bench, each * kPasses * s.blocks * kBlock3, each * kPasses * 18 * (2 * s.blocks - s.nodes));
}

void prepare_solver(benchmark::State& bench) {
  const auto threads = limit(bench);
  Hanging h(bench.range(0));
  System& system = h.system();
  const State& state = h.next();
  NewtonMatrix tangent(system);
  tangent.evaluate(state, kForDirections);
  const NodeValues inertia = system.mass() / 1e-4;
  const NodeVectors b = NodeVectors::Zero(system.nodes(), 3);
  NodeVectors x;
  for (auto _ : bench) {
    system.begin_step();
    (void)tangent.solve_to(0.02, inertia, b, x);
  }
  const Sizes s = sizes_of(h);
  // Read for the coarser level, which is written.
  count(bench, (1 + kCoarse) * kBlock3 * s.blocks, 0);
}

/// One call from the framework into a plugin's library that does next to nothing.
void plugin_call(benchmark::State& bench) {
  Hanging h(9);
  const EnergyTerm& term = *h.system().energies().front().object;
  for (auto _ : bench) {
    TermTraits traits = term.traits();
    benchmark::DoNotOptimize(traits);
  }
}
BENCHMARK(plugin_call);

void arguments(benchmark::internal::Benchmark* b) {
  b->ArgNames({"n", "threads"})
      ->ArgsProduct({{129, 257}, {1, 2}})
      ->UseRealTime()
      ->Unit(benchmark::kMillisecond);
}
BENCHMARK(geometry)->Apply(arguments);
BENCHMARK(geometry_and_force)->Apply(arguments);
BENCHMARK(geometry_force_and_tangent)->Apply(arguments);
BENCHMARK(prepare_solver)->Apply(arguments);
BENCHMARK(solve)->Apply(arguments);

}  // namespace

BENCHMARK_MAIN();
