#include "comparison_table.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "table.h"

namespace deform::app {
namespace {

using Column = std::vector<std::string>;

std::string number(double value) { return std::isnan(value) ? "-" : fmt::format("{:.3g}", value); }

template <class Cell>
Column column(const std::string& heading, const Comparison& comparison, const Cell& cell) {
  Column column{heading};
  for (const RunComparison& run : comparison.runs) column.push_back(cell(run));
  return column;
}

Column against_reference(const std::string& heading, const std::string& figure,
                         const Comparison& comparison) {
  return column(heading, comparison, [&](const RunComparison& run) -> std::string {
    if (run.is_reference) return "reference";
    return number(run.figure(figure));
  });
}

std::string parts_at(const RunComparison& run) {
  if (run.is_reference || !run.impossible.empty()) return "-";
  return run.parting ? fmt::format("{:.3g}", run.parting->time) : "never";
}

std::vector<Column> all_columns(const Comparison& comparison) {
  std::vector<Column> columns{
      column("run", comparison, [](const RunComparison& run) { return run.name; }),
      column("ended", comparison, [](const RunComparison& run) { return run.outcome.status; }),
      against_reference("largest [m]", "distance.max", comparison),
      column("parts at [s]", comparison, parts_at),
      against_reference("rms [m]", "rms", comparison),
      column("step [ms]", comparison,
             [](const RunComparison& run) { return number(run.ms_per_step); }),
  };
  for (const Figure& probe : probe_columns(comparison)) {
    const std::string unit = probe.unit.empty() ? "" : " [" + probe.unit + "]";
    columns.push_back(column(probe.name + unit, comparison, [&](const RunComparison& run) {
      return number(run.figure(probe.name));
    }));
  }
  columns.push_back(against_reference("Hausdorff [m]", "hausdorff", comparison));
  return columns;
}

}  // namespace

std::vector<std::vector<std::string>> comparison_table(const Comparison& comparison,
                                                       std::size_t width) {
  std::vector<std::vector<std::string>> rows(comparison.runs.size() + 1);
  std::size_t used = 0;
  for (const Column& column : all_columns(comparison)) {
    std::size_t widest = 0;
    for (const std::string& cell : column) widest = std::max(widest, width_of(cell));
    // One that is too wide leaves room for narrower ones behind it; the first two always stay.
    if (rows.front().size() >= 2 && used + 2 + widest > width) continue;
    used += 2 + widest;
    for (std::size_t i = 0; i < rows.size(); ++i) rows[i].push_back(column[i]);
  }
  return rows;
}

}  // namespace deform::app
