#pragma once

#include <vector>

#include "deform/compare/comparison.h"

#include "compare/differences.h"

namespace deform {

/// All figures of a run, in a fixed order: probes (final, .min, .max), then against the reference
/// distance, rms, hausdorff (final, .max) and difference.PROBE (final, .max of its absolute value),
/// parts_at [s] (infinite: never), steps, time, done (1 or 0).
[[nodiscard]] std::vector<Figure> figures_of(const RecordedRun& run,
                                             const RunDifferences& differences,
                                             const std::optional<Parting>& parting,
                                             const RunOutcome& outcome);

}  // namespace deform
