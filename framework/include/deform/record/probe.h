/// Probes: figures measured while a simulation runs.
#pragma once

#include <limits>
#include <string>
#include <vector>

#include "deform/record/frame.h"

namespace deform {

/// A column of probes.csv; its header is `name [unit]`, or `name` where the unit is empty.
struct ProbeColumn {
  std::string name;
  std::string unit;
};

/// A figure that a scene does not have (e.g. the normal error without an estimator): an empty
/// field.
inline constexpr double kNoFigure = std::numeric_limits<double>::quiet_NaN();

/// Measures figures at recorded steps. Its columns are fixed once `begin` was called.
class DEFORM_API Probe : public Plugin {
 public:
  static constexpr PluginKind kKind = PluginKind::probe;
  ~Probe() override;

  virtual void begin(const RunContext& context);
  [[nodiscard]] virtual std::vector<ProbeColumn> columns() const = 0;
  /// Called after every step, recorded or not.
  virtual void follow(const Frame& frame);
  /// Called within a step at each time at which loads or supports are not smooth
  /// (Plugin::next_break). The frame's step is the last that was completed, its step_size the time
  /// since that or since the last such call; the state is at the time of the break.
  virtual void follow_break(const Frame& frame);
  /// Writes one figure a column.
  virtual void measure(const Frame& frame, Values figures) = 0;
};

}  // namespace deform
