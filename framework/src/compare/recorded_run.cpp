#include "compare/recorded_run.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <string_view>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "deform/error.h"

#include "files/files.h"
#include "json/json_file.h"

namespace deform {
namespace {

namespace fs = std::filesystem;

Json read_json(const fs::path& file) {
  Json json = read_json_object(file);
  std::error_code error;
  if (json.is_null() && fs::exists(file, error))
    throw InputError(fmt::format("{} is not what a run writes", file.string()));
  return json;
}

/// Calls action(number, text) for each field of a line without quotes.
template <class Action>
void for_fields(std::string_view line, const Action& action) {
  for (std::size_t number = 0;; ++number) {
    const std::size_t comma = line.find(',');
    action(number, line.substr(0, comma));
    if (comma == std::string_view::npos) return;
    line.remove_prefix(comma + 1);
  }
}

/// Bytes of the first line: a name that is quoted may hold others.
std::size_t end_of_header(std::string_view text) {
  bool is_quoted = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '"') is_quoted = !is_quoted;
    if (text[i] == '\n' && !is_quoted) return i + 1;
  }
  return text.size();
}

double figure_of(std::string_view text) {
  double figure = std::numeric_limits<double>::quiet_NaN();
  std::from_chars(text.data(), text.data() + text.size(), figure);
  return figure;
}

long step_of(double figure, const fs::path& file) {
  if (!(figure >= 0 && figure < 0x1p53))
    throw InputError(fmt::format("{} has a row without a number of steps", file.string()));
  return static_cast<long>(figure);
}

/// The columns' names are those of summary.json: the rows hold numbers only.
FigureTable read_probes(const fs::path& file, const Json& summary) {
  FigureTable table;
  if (!summary.is_object() || !summary.contains("probes")) return table;
  if (!summary["probes"].is_object()) throw InputError("/probes of summary.json is no object");
  for (const auto& [name, figure] : summary["probes"].items()) {
    const auto unit = figure.find("unit");
    if (!figure.is_object() || unit == figure.end() || !unit->is_string())
      throw InputError(fmt::format("/probes/{} of summary.json has no unit", name));
    table.names.push_back(name);
    table.units.push_back(unit->get<std::string>());
  }
  const auto text = read_file(file);
  if (!text) return table;
  std::string_view rest = *text;
  rest.remove_prefix(end_of_header(rest));
  while (!rest.empty()) {
    const std::size_t end = rest.find('\n');
    if (end == std::string_view::npos) break;  // cut off
    Moment moment;
    std::vector<double> row(table.names.size(), std::numeric_limits<double>::quiet_NaN());
    for_fields(rest.substr(0, end), [&](std::size_t number, std::string_view field) {
      const double figure = figure_of(field);
      if (number == 0) moment.step = step_of(figure, file);
      if (number == 1) moment.time = figure;
      if (number >= 2 && number - 2 < row.size()) row[number - 2] = figure;
    });
    table.moments.push_back(moment);
    table.figures.push_back(std::move(row));
    rest.remove_prefix(end + 1);
  }
  return table;
}

double spacing(const std::vector<Moment>& moments) {
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 1; i < moments.size(); ++i)
    least = std::min(least, moments[i].time - moments[i - 1].time);
  return least;
}

}  // namespace

RecordedRun read_tables(const fs::path& folder) {
  RecordedRun run;
  run.folder = folder;
  run.summary = read_json(folder / "summary.json");
  run.manifest = read_json(folder / "manifest.json");
  try {
    run.probes = read_probes(folder / "probes.csv", run.summary);
  } catch (const InputError& e) {
    throw InputError(
        fmt::format("the probes of {} are not what a run writes: {}", folder.string(), e.what()));
  }
  return run;
}

void open_trajectory(RecordedRun& run) {
  const fs::path file = run.folder / kTrajectoryFile;
  std::error_code error;
  if (fs::exists(file, error)) run.trajectory.emplace(file);
}

RecordedRun read_run(const fs::path& folder) {
  RecordedRun run = read_tables(folder);
  open_trajectory(run);
  return run;
}

std::vector<std::pair<std::size_t, std::size_t>> same_times(const std::vector<Moment>& a,
                                                            const std::vector<Moment>& b) {
  const double finest = std::min(spacing(a), spacing(b));
  const double latest = std::max(a.empty() ? 0 : a.back().time, b.empty() ? 0 : b.back().time);
  const double slack = std::isfinite(finest) ? 1e-6 * finest : 1e-9 * latest;
  std::vector<std::pair<std::size_t, std::size_t>> pairs;
  for (std::size_t i = 0, j = 0; i < a.size() && j < b.size();) {
    const double apart = a[i].time - b[j].time;
    if (std::abs(apart) <= slack) {
      pairs.emplace_back(i++, j++);
    } else {
      ++(apart < 0 ? i : j);
    }
  }
  return pairs;
}

}  // namespace deform
