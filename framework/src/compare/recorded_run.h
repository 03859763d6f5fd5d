/// What a run left behind, read back.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "deform/record/trajectory.h"

#include "json/json.h"

namespace deform {

/// probes.csv.
struct FigureTable {
  std::vector<std::string> names, units;     ///< without step and time
  std::vector<Moment> moments;               ///< a row each
  std::vector<std::vector<double>> figures;  ///< of each row; NaN where there is none
};

struct RecordedRun {
  std::filesystem::path folder;
  Json summary, manifest;  ///< null where there is none
  FigureTable probes;
  std::optional<Trajectory> trajectory;
};

/// Reads what is there of a run directory; what is not there stays empty. Throws InputError for
/// files that are not what a run writes.
[[nodiscard]] RecordedRun read_run(const std::filesystem::path& folder);
/// The same in two parts, for whom one of them is worth having without the other: all but the
/// states, and these.
[[nodiscard]] RecordedRun read_tables(const std::filesystem::path& folder);
void open_trajectory(RecordedRun& run);

/// Pairs of numbers (i, j) of moments at the same time, ascending. Times that differ by less than
/// 1e-6 of the spacing (1e-9 of the time, where there is no second one) are the same: steps of
/// different size reach them with other roundings.
[[nodiscard]] std::vector<std::pair<std::size_t, std::size_t>> same_times(
    const std::vector<Moment>& a, const std::vector<Moment>& b);

}  // namespace deform
