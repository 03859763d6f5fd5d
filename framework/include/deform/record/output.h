/// Outputs: writers of files below the run directory.
#pragma once

#include <functional>

#include "deform/record/frame.h"

namespace deform {

/// Writes frames. `begin`, then `write` at every recorded step, then `end` (also after a divergence
/// or an interruption: what was written so far must be readable).
class DEFORM_API Output : public Plugin {
 public:
  static constexpr PluginKind kKind = PluginKind::output;
  ~Output() override;
  /// What it alone writes below the run's folder, "vtk": two outputs of a scene may not say the
  /// same. Empty: says nothing.
  [[nodiscard]] virtual std::string place() const;
  virtual void begin(const RunContext& context) = 0;
  virtual void write(const Frame& frame) = 0;
  /// What is left to do to write a frame, from copies: it is done in another thread while the run
  /// goes on, one job after another in the order of frames, before a checkpoint that counts on it
  /// and before `end`. It must not touch what `take`, `save` and `load` do, nor the frame. By
  /// default the frame is written at once, and nothing is left (empty).
  [[nodiscard]] virtual std::function<void()> take(const Frame& frame);
  virtual void end() = 0;
};

}  // namespace deform
