/// probes.csv and the figures that sum it up.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "deform/record/probe.h"

#include "files/files.h"

namespace deform {

/// A field of a CSV file (RFC 4180): in quotes where it must be.
[[nodiscard]] std::string csv_field(std::string_view text);

/// "name [unit]", or the name alone where there is no unit.
[[nodiscard]] std::string header_of(const ProbeColumn& column);

/// Makes names unique: the second "lowest" becomes "lowest_2".
[[nodiscard]] std::vector<ProbeColumn> with_unique_names(std::vector<ProbeColumn> columns);

/// What became of a column; kNoFigure until it has a figure.
struct ColumnSummary {
  double last = kNoFigure;
  double minimum = kNoFigure;
  double maximum = kNoFigure;

  void add(double figure);
};

/// Writes probes.csv: `step,time [s]` and a column a figure; a row a call, in the file when the
/// call returns.
class ProbeTable {
 public:
  /// Starts the file, or goes on after the first `keep` bytes of the one that is there. Throws
  /// Error when the file cannot be written.
  ProbeTable(const std::filesystem::path& file, std::span<const ProbeColumn> columns,
             std::size_t keep = 0);
  /// Figures that are NaN become empty fields; the others come back with the same bits when read.
  void append(long step, double time, std::span<const double> figures);
  /// Has all rows put on disk; returns what the file holds. Throws Error when it cannot.
  [[nodiscard]] WrittenFile sync();
  /// Ends the file; returns what it holds. Throws Error when it cannot.
  WrittenFile close();

 private:
  AppendFile file_;
  std::string row_;
};

}  // namespace deform
