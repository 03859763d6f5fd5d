#include "sheet_case.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <vector>

#include <sys/resource.h>
#include <tbb/global_control.h>

#include "deform/error.h"
#include "deform/simulation/simulation.h"
#include "deform/solve/step_times.h"

#include "allocations.h"

namespace deform::bench {
namespace {

constexpr double kDuration = 0.4;  // s; the motion of the hanging sheet is chaotic from 0.5 s on

Scene scene_of(const SheetCase& c, const PluginRegistry& registry) {
  const bool hanging = c.scene == "hanging";
  std::vector<Replacement> changes{
      {"/surface/nodes", nlohmann::json{c.nodes, c.nodes}.dump()},
      {"/integrator/plugin", c.integrator},
      {"/integrator/step", hanging ? "0.01" : "0.02"},
      {"/probes", "[]"},
  };
  if (!hanging) {
    const std::string xi = c.scene.substr(c.scene.rfind('_') + 1);
    changes.push_back({"/energies/1", R"({"plugin": "bending_variational", "xi": )" + xi + "}"});
  }
  if (c.solver != "automatic") changes.push_back({"/solver", R"({"plugin": ")" + c.solver + "\"}"});
  if (c.tolerance > 0)
    changes.push_back({"/integrator/tolerance", nlohmann::json(c.tolerance).dump()});
  if (c.newton_error > 0)
    changes.push_back({"/integrator/newton_error", nlohmann::json(c.newton_error).dump()});
  const std::string file = hanging ? "hanging_sheet.json" : "sheet_p.json";
  return read_scene(std::string(DEFORM_BENCHMARK_SCENES) + "/" + file, registry, changes);
}

double quantile(std::vector<double> values, double fraction) {
  if (values.empty()) return 0;
  std::sort(values.begin(), values.end());
  const double place = fraction * static_cast<double>(values.size() - 1);
  const auto i = static_cast<std::size_t>(place);
  const double above = values[std::min(i + 1, values.size() - 1)];
  return values[i] + (place - static_cast<double>(i)) * (above - values[i]);
}

/// Of this process [bytes].
double peak_memory() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return 1024.0 * static_cast<double>(usage.ru_maxrss);
}

/// What is noted of every step.
struct Series {
  std::vector<double> ms, newton, own, total;

  void step(Simulation& simulation) {
    const Allocations before = allocations();
    const auto begin = std::chrono::steady_clock::now();
    simulation.step();
    const std::chrono::duration<double, std::milli> took = std::chrono::steady_clock::now() - begin;
    const Allocations after = allocations();
    ms.push_back(took.count());
    newton.push_back(static_cast<double>(simulation.system().step_report().iterations));
    own.push_back(static_cast<double>(after.own - before.own));
    total.push_back(static_cast<double>(after.total - before.total));
  }
};

nlohmann::json figures(const Series& s, double first, const StepTimes& times) {
  const double steps = std::max<double>(1, static_cast<double>(s.ms.size()));
  const auto part = [&](double seconds) { return 1e3 * seconds / steps; };
  return {{"steps", s.ms.size()},
          {"ms",
           {{"first", first},
            {"lower_quartile", quantile(s.ms, 0.25)},
            {"median", quantile(s.ms, 0.5)},
            {"upper_quartile", quantile(s.ms, 0.75)}}},
          {"newton", {{"median", quantile(s.newton, 0.5)}, {"most", quantile(s.newton, 1)}}},
          {"parts_ms",
           {{"geometry", part(times.geometry)},
            {"assembly", part(times.assembly)},
            {"factorisation", part(times.factorisation)},
            {"solve", part(times.solve)}}},
          {"allocations", {{"own", quantile(s.own, 0.5)}, {"total", quantile(s.total, 0.5)}}}};
}

}  // namespace

nlohmann::json description(const SheetCase& c) {
  return {{"scene", c.scene},
          {"nodes", c.nodes},
          {"integrator", c.integrator},
          {"solver", c.solver},
          {"threads", c.threads},
          {"tolerance", c.tolerance},
          {"newton_error", c.newton_error}};
}

nlohmann::json measure(const SheetCase& c) {
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                  static_cast<std::size_t>(c.threads));
  const auto registry = std::make_shared<const PluginRegistry>();
  const double before = peak_memory();
  Simulation simulation(scene_of(c, *registry), registry);
  find_own_code();
  Series first, steady;
  StepTimes times;
  const TimesAddedTo counted(&times);
  std::string status = "done";
  std::vector<double> lowest;
  const double step = c.scene == "hanging" ? 0.01 : 0.02;
  const long all = std::lround(kDuration / step);
  const long wanted = c.steps > 0 ? std::min(c.steps, all) : all;
  try {
    for (long i = 1; i <= wanted; ++i) {
      (i == 1 ? first : steady).step(simulation);
      if (i == 1) times = {};
      if (i % (all / 4) == 0) lowest.push_back(simulation.state().r.col(2).minCoeff());
    }
  } catch (const Error& error) {
    status = error.what();
  }
  nlohmann::json result = figures(steady, quantile(first.ms, 1), times);
  result["status"] = status;
  result["reached"] = simulation.state().time;
  result["lowest"] = lowest;
  result["memory"] = (peak_memory() - before) / static_cast<double>(c.nodes * c.nodes);
  result["solver_choice"] = simulation.system().solver_choice();
  return result;
}

}  // namespace deform::bench
