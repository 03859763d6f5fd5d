/// Integrators: time, prescribed positions, rest, free fall, convergence.
#include <cmath>

#include <fmt/format.h>

#include "check/bitwise.h"
#include "check/contracts.h"
#include "plugin/guard.h"

namespace deform {
namespace {

/// A scene with the subject's integrator and what else a check needs.
class IntegratorScene {
 public:
  IntegratorScene(const Subject& subject, const Terrain& terrain) : subject_(subject) {
    scene_ = Json{{"surface", terrain.surface},
                  {"material", {{"density", 0.1}}},
                  {"energies", Json::array({{{"plugin", "stretching"}, {"eta", 0.01}},
                                            {{"plugin", "bending_variational"}, {"xi", 1e-6}}})},
                  {"forces", Json::array()},
                  {"constraints", Json::array()}};
  }
  Json& operator[](const char* key) { return scene_[key]; }

  [[nodiscard]] Simulation simulation(double step, double duration) const {
    Json scene = scene_;
    scene["integrator"] = subject_.use();
    scene["integrator"]["step"] = step;
    scene["duration"] = duration;
    return {read_scene_text(scene.dump(), kCheckedScene, ".", *subject_.registry()),
            subject_.registry()};
  }
  /// The positions at the end.
  [[nodiscard]] NodeVectors run(double step, double duration) const {
    Simulation s = simulation(step, duration);
    while (s.steps() < s.scene().steps()) s.step();
    return s.state().r;
  }

 private:
  const Subject& subject_;
  Json scene_;
};

const Json kGravity{{"plugin", "gravity"}, {"acceleration", {0, 0, -1}}};

void check_rest(const Subject& subject, const Terrain& terrain, Checks& checks) {
  const IntegratorScene scene(subject, terrain);
  const Simulation begin = scene.simulation(0.01, 0.1);
  checks.below("without force nothing moves [m]",
               (scene.run(0.01, 0.1) - begin.state().r).cwiseAbs().maxCoeff(), 1e-10);
}

void check_time_and_prescription(const Subject& subject, const Terrain& terrain, Checks& checks) {
  IntegratorScene scene(subject, terrain);
  scene["constraints"] = Json::array({{{"plugin", "move"},
                                       {"where", {{"boundary", "left"}}},
                                       {"times", {0, 1}},
                                       {"displacements", {{0, 0, 0}, {0, 0, 0.1}}}}});
  Simulation s = scene.simulation(0.01, 0.1);
  const auto integrator = subject.make<Integrator>(terrain).object;
  State state = s.state();
  s.system().begin_step();
  for (int i = 1; i <= 3; ++i) {
    integrator->advance(s.system(), state, 0.01);
    checks.below("advances time by the step [s]", std::abs(state.time - 0.01 * i), 1e-12);
    NodeVectors target = state.r;
    s.system().constraints().prescribe(0.01 * i, target);
    checks.below("prescribed positions end where the constraint says [m]",
                 (state.r - target).cwiseAbs().maxCoeff(), 1e-12);
    s.system().begin_step();
  }
}

void report_free_fall(const Subject& subject, const Terrain& terrain, Checks& checks) {
  IntegratorScene scene(subject, terrain);
  scene["forces"] = Json::array({kGravity});
  constexpr double T = 0.2;
  const NodeVectors begin = scene.simulation(0.01, T).state().r;
  const auto error = [&](double step) {
    const NodeVectors fallen = scene.run(step, T) - begin;
    NodeVectors exact = NodeVectors::Zero(begin.rows(), 3);
    exact.col(2).setConstant(-0.5 * T * T);
    return (fallen - exact).cwiseAbs().maxCoeff();
  };
  checks.report("free fall of 0.02 m: error", fmt::format("{:.2g} m with steps of 0.01 s, {:.2g} m "
                                                          "with 0.005 s",
                                                          error(0.01), error(0.005)));
}

/// Order at which the hanging sheet's end state converges as the step is halved.
void report_order(const Subject& subject, const Terrain& terrain, Checks& checks) {
  IntegratorScene scene(subject, terrain);
  scene["forces"] = Json::array({kGravity});
  scene["constraints"] = Json::array({{{"plugin", "pin"}, {"where", {{"boundary", "left"}}}}});
  constexpr double T = 0.2;
  const NodeVectors coarse = scene.run(0.01, T), middle = scene.run(0.005, T),
                    fine = scene.run(0.0025, T);
  const double first = (coarse - middle).norm(), second = (middle - fine).norm();
  checks.report(
      "hanging sheet: order in the step",
      second > 0 ? fmt::format("{:.2f}", std::log2(first / second)) : "steps do not matter");
}

}  // namespace

void check_integrator_contract(const Subject& subject, Checks& checks) {
  const bool is_static = guarded("the integrator", "saying what it is", [&] {
    return subject.make<Integrator>(terrains(9, 7).front()).object->is_static();
  });
  for (const Terrain& terrain : {terrains(9, 7).front(), terrains(9, 7)[4]}) {
    checks.at(terrain.name);
    checks.runs("steps", [&] {
      check_rest(subject, terrain, checks);
      check_time_and_prescription(subject, terrain, checks);
    });
  }
  checks.at("");
  if (!is_static) {
    checks.runs("steps", [&] {
      report_free_fall(subject, terrains(9, 7).front(), checks);
      report_order(subject, terrains(9, 7).front(), checks);
    });
  }
  check_run(subject, checks);
}

}  // namespace deform
