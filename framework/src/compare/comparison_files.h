/// The files of a comparison directory beside its runs'.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "deform/compare/comparison.h"

#include "compare/differences.h"

namespace deform {

/// What was read and measured of one run.
struct MeasuredRun {
  RecordedRun recorded;
  RunDifferences differences;
};

/// comparison.csv: a row a run and recorded time, in the order of the plan: no times of day or
/// of computing, so that it depends on nothing but the runs.
[[nodiscard]] std::string comparison_csv(const Comparison& comparison,
                                         const std::vector<MeasuredRun>& measured);
/// cost.csv: a row a run; milliseconds a step by part, memory.
[[nodiscard]] std::string cost_csv(const Comparison& comparison,
                                   const std::vector<MeasuredRun>& measured);
/// summary.json of a folder: all figures, and what report.html is made of.
[[nodiscard]] std::string summary_json(const Comparison& comparison, const ComparisonPlan& plan,
                                       const std::filesystem::path& folder);
/// manifest.json, which also makes the folder known as one of deform's.
[[nodiscard]] std::string manifest_json(const ComparisonOptions& options,
                                        const ComparisonPlan& plan, const std::string& status);

/// Time of computing a step [ms]; NaN where no step was timed.
[[nodiscard]] double ms_per_step(const RecordedRun& run);

}  // namespace deform
