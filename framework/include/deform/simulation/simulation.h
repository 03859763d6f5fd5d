/// A simulation: a scene's model, its integrator and its state.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <string>

#include "deform/export.h"
#include "deform/record/frame.h"
#include "deform/simulation/scene.h"
#include "deform/solve/integrator.h"
#include "deform/solve/system.h"

namespace deform {

/// Made from a scene; advances step by step; records nothing.
class DEFORM_API Simulation {
 public:
  /// Makes every plugin object. Throws InputError with every problem found (a selection of no node,
  /// a file that is not there, …). `mirrored`: the whole world reflected at z = 0.
  Simulation(Scene scene, std::shared_ptr<const PluginRegistry> registry, bool mirrored = false);
  ~Simulation();

  /// What is told of a state within a step: see `step`.
  using AtBreak = std::function<void(const Frame&)>;
  /// One step of the scene, in parts that end where the model is not smooth in time
  /// (Plugin::next_break); `at_break` sees the state there, with Frame::step_size the length of the
  /// part that ends. Statics, which look for the equilibrium at the step's end, take it as a whole.
  /// Throws Diverged when the state is not finite or a node is beyond all bounds, PluginFailure
  /// when a plugin throws; the state is then that before the step.
  void step(const AtBreak& at_break = {});

  /// From now on a step throws Error with ExitCode::interrupted soon after `stop` becomes true, and
  /// so do those of `mirrored` runs made later. The state is then that before the step, but plugins
  /// may remember something of it: go on from what was saved before. Null: nothing stops steps.
  void stop_when(const std::atomic<bool>* stop);

  [[nodiscard]] const Scene& scene() const;
  [[nodiscard]] System& system();
  [[nodiscard]] const Named<Integrator>& integrator() const;
  [[nodiscard]] const State& state() const;
  [[nodiscard]] long steps() const;
  /// The view for probes and outputs; brings the geometry up to date.
  [[nodiscard]] Frame frame();
  /// The same scene reflected at z = 0, at its initial state.
  [[nodiscard]] std::unique_ptr<CompanionRun> mirrored() const;
  [[nodiscard]] std::shared_ptr<const PluginRegistry> registry() const;

  /// Extent of the surface: the largest side of the rest state's bounding box [m].
  [[nodiscard]] double size() const;

  void save(Memory& memory) const;
  void load(const Memory& memory);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace deform
