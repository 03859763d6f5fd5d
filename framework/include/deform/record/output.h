/// Outputs: writers of files below the run directory.
#pragma once

#include "deform/record/frame.h"

namespace deform {

/// Writes frames. `begin`, then `write` at every recorded step, then `end` (also after a divergence
/// or an interruption: what was written so far must be readable).
class DEFORM_API Output : public Plugin {
 public:
  static constexpr PluginKind kKind = PluginKind::output;
  ~Output() override;
  virtual void begin(const RunContext& context) = 0;
  virtual void write(const Frame& frame) = 0;
  virtual void end() = 0;
};

}  // namespace deform
