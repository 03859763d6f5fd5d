/// What probes and outputs see of a simulation at a recorded step.
#pragma once

#include <functional>
#include <memory>
#include <optional>

#include "deform/solve/integrator.h"
#include "deform/solve/system.h"

namespace deform {

struct Frame {
  long step = 0;
  double step_size = 0;  ///< [s]
  const State& state;
  const NodeVectors& previous_r;  ///< (N × 3) positions at which the last step began [m]
  const System& system;

  /// (N × 3) of the nodes alone: a state has scalar unknowns behind them where a model has some.
  [[nodiscard]] auto positions() const { return state.r.topRows(system.nodes()); }
  [[nodiscard]] auto velocities() const { return state.v.topRows(system.nodes()); }
  /// All geometry at the samples of a set, now and where the last step began.
  [[nodiscard]] std::shared_ptr<const Geometry> geometry(const SampleSet& samples) const {
    return system.terms().geometry(state.r, samples);
  }
  [[nodiscard]] std::shared_ptr<const Geometry> previous_geometry(const SampleSet& samples) const {
    return system.terms().geometry(previous_r, samples);
  }
};

/// A simulation that runs beside the one that is recorded, e.g. its mirror image.
class DEFORM_API CompanionRun {
 public:
  virtual ~CompanionRun();
  virtual void step() = 0;
  [[nodiscard]] virtual const State& state() const = 0;
  [[nodiscard]] virtual long steps() const = 0;
  virtual void save(Memory& memory) const = 0;
  virtual void load(const Memory& memory) = 0;
};

/// What a probe or output may ask for when a run begins.
struct RunContext {
  std::filesystem::path folder;  ///< of the run; outputs write below it
  std::string title;
  const System& system;
  /// Makes the same simulation mirrored at z = 0, at its initial state.
  std::function<std::unique_ptr<CompanionRun>()> mirrored;
  /// The run goes on from the checkpoint at this step: what was written of earlier ones is there
  /// and stays, this and later ones are written anew, and Plugin::load follows.
  std::optional<long> resumed_at;
};

}  // namespace deform
