/// Short runs: the same bits on any number of threads, and when they go on in fresh objects.
#include <cmath>

#include "check/bitwise.h"
#include "check/contracts.h"

namespace deform {
namespace {

constexpr int kSteps = 4;

std::vector<double> numbers_of(const State& state) {
  std::vector<double> numbers(state.r.data(), state.r.data() + state.r.size());
  numbers.insert(numbers.end(), state.v.data(), state.v.data() + state.v.size());
  return numbers;
}

std::vector<double> run(Simulation simulation, int steps) {
  for (int i = 0; i < steps; ++i) simulation.step();
  return numbers_of(simulation.state());
}

std::vector<double> run_with_a_break(const Subject& subject, const Terrain& terrain) {
  Memory memory;
  {
    Simulation first = subject.simulation(terrain);
    for (int i = 0; i < kSteps / 2; ++i) first.step();
    first.save(memory);
  }
  Simulation second = subject.simulation(terrain);
  second.load(memory);
  for (int i = kSteps / 2; i < kSteps; ++i) second.step();
  return numbers_of(second.state());
}

/// Of the times at which a part is not smooth, as many are looked at.
constexpr int kMostBreaks = 100;

}  // namespace

void check_breaks(const Plugin& part, Checks& checks) {
  bool ascends = true;
  double time = -1;
  for (int i = 0; i < kMostBreaks && ascends && std::isfinite(time); ++i) {
    const double next = part.next_break(time);
    ascends = next > time;
    time = next;
  }
  checks.holds("the times at which it is not smooth ascend", ascends,
               "asked for a later time, it named one that is not");
}

void check_run(const Subject& subject, Checks& checks,
               const std::function<bool(const Terrain&)>& suits) {
  for (const Terrain& terrain : {terrains(17, 13).front(), terrains(9, 7)[4]}) {
    checks.at(terrain.name);
    checks.runs("takes part in a run", [&] {
      if (!suits(terrain)) {
        checks.report("run", "left out: its ties mix components here, which takes Newton's method");
        return;
      }
      const std::vector<double> expected = run(subject.simulation(terrain), kSteps);
      checks.holds("same run on any number of threads",
                   same_on_threads([&] { return run(subject.simulation(terrain), kSteps); }),
                   "one thread and several differ");
      checks.holds("saved and loaded half-way, the run is the same",
                   same_bits(run_with_a_break(subject, terrain), expected),
                   "the state differs: something that the plugin remembers is not saved");
    });
  }
}

}  // namespace deform
