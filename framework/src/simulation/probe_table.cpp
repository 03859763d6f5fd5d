#include "simulation/probe_table.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <set>
#include <utility>

#include <fmt/format.h>

namespace deform {

std::string csv_field(std::string_view text) {
  if (text.find_first_of(",\"\r\n") == std::string_view::npos) return std::string(text);
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"') quoted += '"';
    quoted += c;
  }
  return quoted + '"';
}

std::string header_of(const ProbeColumn& column) {
  return column.unit.empty() ? column.name : fmt::format("{} [{}]", column.name, column.unit);
}

std::vector<ProbeColumn> with_unique_names(std::vector<ProbeColumn> columns) {
  std::set<std::string> taken{"step", "time"};
  for (ProbeColumn& column : columns) {
    const std::string name = column.name;
    for (int number = 2; !taken.insert(column.name).second; ++number) {
      column.name = fmt::format("{}_{}", name, number);
    }
  }
  return columns;
}

void ColumnSummary::add(double figure) {
  if (std::isnan(figure)) return;
  last = figure;
  minimum = std::fmin(minimum, figure);  // fmin and fmax pass over NaN
  maximum = std::fmax(maximum, figure);
}

ProbeTable::ProbeTable(const std::filesystem::path& file, std::span<const ProbeColumn> columns,
                       std::size_t keep)
    : file_(file, keep) {
  if (keep > 0) return;
  row_ = "step,time [s]";
  for (const ProbeColumn& column : columns) row_ += ',' + csv_field(header_of(column));
  row_ += '\n';
  file_.append(row_);
}

WrittenFile ProbeTable::sync() {
  file_.sync();
  return file_.written();
}

WrittenFile ProbeTable::close() {
  file_.close();
  return file_.written();
}

void ProbeTable::append(long step, double time, std::span<const double> figures) {
  row_.clear();
  fmt::format_to(std::back_inserter(row_), "{},{}", step, time);
  for (const double figure : figures) {
    row_ += ',';
    if (!std::isnan(figure)) fmt::format_to(std::back_inserter(row_), "{}", figure);
  }
  row_ += '\n';
  file_.append(row_);
}

}  // namespace deform
