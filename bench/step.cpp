/// Time of one semi-implicit step of sheet P and its split, by method and resolution; and of one
/// written frame. xi is 1e-6 for the variational form; the others, which such a step does not carry
/// at 129² nodes, get 1e-10: what a step costs does not depend on it.
#include <memory>
#include <stdlib.h>
#include <unistd.h>

#include <benchmark/benchmark.h>
#include <fmt/format.h>
#include <tbb/global_control.h>

#include "deform/record/output.h"
#include "deform/simulation/simulation.h"
#include "deform/solve/step_times.h"

namespace {
using namespace deform;

std::shared_ptr<const PluginRegistry> built_in() {
  static const auto registry = std::make_shared<const PluginRegistry>();
  return registry;
}

/// Sheet P with n × n nodes; the load keeps its place and size.
Simulation sheet_p(std::int64_t n, const std::string& bending) {
  const std::string text = fmt::format(R"({{
    "surface": {{"plugin": "grid", "nodes": [{0}, {0}], "size": [1, 1],
                 "differences": "forward", "border": "paper", "weights": "equal"}},
    "material": {{"density": 0.1, "damping": 1}},
    "energies": [{{"plugin": "stretching", "eta": 0.01}}, {1}],
    "forces": [{{"plugin": "point_load", "force": [0, 0, -0.01],
                 "where": {{"centre": [0.5, 0.5], "radius": 0.06}}}}],
    "constraints": [{{"plugin": "pin", "where": {{"boundary": "all"}}}}],
    "integrator": {{"plugin": "semi_implicit", "step": 0.02}}, "duration": 2}})",
                                       n, bending);
  return {read_scene_text(text, "bench", ".", *built_in()), built_in()};
}

constexpr const char* kMethods[] = {
    R"({"plugin": "bending_variational", "xi": 1e-6})",
    R"({"plugin": "bending", "xi": 1e-10, "normal": {"plugin": "exact"}})",
    R"({"plugin": "bending", "xi": 1e-10, "normal": {"plugin": "gauss", "delta": 0.5}})"};
constexpr const char* kNames[] = {"variational (cholmod)", "exact divergence (cholmod)",
                                  "gauss divergence (umfpack)"};

/// range(0): nodes a side; range(1): method; range(2): threads.
void step(benchmark::State& bench) {
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                  static_cast<std::size_t>(bench.range(2)));
  Simulation simulation = sheet_p(bench.range(0), kMethods[bench.range(1)]);
  simulation.step();  // analyses the pattern
  StepTimes t;
  const TimesAddedTo counted(&t);
  for (auto _ : bench) simulation.step();
  const double steps = static_cast<double>(bench.iterations());
  const auto milliseconds = [&](double seconds) { return 1e3 * seconds / steps; };
  bench.counters["geometry_ms"] = milliseconds(t.geometry);
  bench.counters["assembly_ms"] = milliseconds(t.assembly);
  bench.counters["factor_ms"] = milliseconds(t.factorisation);
  bench.counters["solve_ms"] = milliseconds(t.solve);
  bench.SetLabel(kNames[bench.range(1)]);
}
/// One frame of the vtk output; range(0): nodes a side.
void write_frame(benchmark::State& bench) {
  Simulation simulation = sheet_p(bench.range(0), kMethods[0]);
  simulation.step();
  const Setup setup(
      [](const PluginUse& use, const Setup& s) { return built_in()->create(use, s); });
  const auto output = built_in()->create<Output>({PluginKind::output, "vtk", nullptr, ""}, setup);
  const std::filesystem::path folder =
      std::filesystem::temp_directory_path() / ("deform_bench_" + std::to_string(getpid()));
  std::filesystem::create_directories(folder);
  const RunContext context{folder, "bench", simulation.system(), {}};
  output->begin(context);
  for (auto _ : bench) output->write(simulation.frame());
  output->end();
  std::filesystem::remove_all(folder);
}
BENCHMARK(write_frame)
    ->ArgName("n")
    ->Arg(65)
    ->Arg(129)
    ->Arg(257)
    ->Unit(benchmark::kMillisecond)
    ->Iterations(5);

BENCHMARK(step)
    ->ArgNames({"n", "method", "threads"})
    ->ArgsProduct({{65, 129, 257}, {0, 1, 2}, {1, 2}})
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime()
    ->Iterations(5);

}  // namespace

int main(int argc, char** argv) {
  setenv("OPENBLAS_NUM_THREADS", "1", 0);
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
  benchmark::RunSpecifiedBenchmarks();
  benchmark::Shutdown();
  return 0;
}
