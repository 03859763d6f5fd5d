/// Comparisons: several runs of one scene, measured against each other.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "deform/compare/plan.h"
#include "deform/compare/runner.h"
#include "deform/export.h"

namespace deform {

/// A figure of a run; NaN where there is none.
struct Figure {
  std::string name;  ///< "flatness", "distance.max"
  std::string unit;
  double value = 0;
};

/// Where a run first is farther from the reference than the tolerance, at a recorded step.
struct Parting {
  long step = 0;
  double time = 0;      ///< [s]
  Vec2 where{0, 0};     ///< (a1, a2) [m]
  Index node = 0;       ///< of the run's surface, or the reference's where that one shows more
  double distance = 0;  ///< [m]
};

struct RunComparison {
  std::string name;
  RunOutcome outcome;
  std::vector<std::string> dropped;  ///< pointers of parameters that a plugin put in has not
  std::string same_as;  ///< an earlier run with the very same scene; empty: there is none
  bool is_reference = false;
  std::string impossible;  ///< why it was not measured against the reference; empty: it was
  std::size_t compared = 0, recorded = 0;  ///< recorded times at which it was measured, and all
  std::optional<Parting> parting;
  /// Final figures of the probes by their names, then PROBE.min and PROBE.max, and what differs
  /// from the reference: see docs/compare.md.
  std::vector<Figure> figures;
  double ms_per_step = 0;  ///< NaN where no step was timed

  /// NaN where there is none of that name.
  [[nodiscard]] DEFORM_API double figure(const std::string& name) const;
};

/// A claim of an expectation file, and what became of it.
struct Claim {
  std::string text;
  bool holds = false;
  std::string explanation;  ///< the figures that it names; why it could not be looked at
};

struct ComparisonOptions {
  ComparisonRequest request;
  RunnerOptions runner;                   ///< its folder is the comparison's
  bool force = false;                     ///< replace an existing comparison directory
  std::filesystem::path expectation;      ///< empty: none
  std::vector<std::string> command_line;  ///< for the manifest
  std::string commit{};                   ///< of the program's sources, for the manifest
};

struct Comparison {
  /// What the others are measured against: the planned one or, where that did not end as done, the
  /// first run that did (the planned one again where none did).
  std::string reference;
  std::string planned_reference;
  double tolerance = 0;                ///< [m]
  std::vector<RunComparison> runs;     ///< in the order of the plan
  std::vector<std::string> sentences;  ///< what came out, the first one being the headline
  std::vector<Claim> claims;
};

/// The probes' columns that any of the runs has, in the order in which they come up; no values.
[[nodiscard]] DEFORM_API std::vector<Figure> probe_columns(const Comparison& comparison);

/// Plans, runs, measures, and writes the comparison directory: a run directory a run,
/// comparison.csv, cost.csv, summary.json, manifest.json. Throws InputError before anything is
/// written for a scene, a reference or an expectation file that is wrong; Error with
/// ExitCode::interrupted when it was interrupted.
[[nodiscard]] DEFORM_API Comparison compare(const ComparisonOptions& options,
                                            const std::shared_ptr<const PluginRegistry>& registry);

}  // namespace deform
