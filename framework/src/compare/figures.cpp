#include "compare/figures.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace deform {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

double number(const Json& json, const char* key) {
  const auto found = json.find(key);
  return found != json.end() && found->is_number() ? found->get<double>() : kNone;
}

/// The last and the largest of a figure over all rows, as NAME and NAME.max.
template <class Get>
void add_course(std::vector<Figure>& figures, const std::string& name, const std::string& unit,
                const RunDifferences& differences, const Get& get) {
  double last = kNone, most = kNone;
  for (const Difference& row : differences.rows) {
    const double value = get(row);
    if (std::isnan(value)) continue;
    last = value;
    most = std::fmax(most, std::abs(value));
  }
  figures.push_back({name, unit, last});
  figures.push_back({name + ".max", unit, most});
}

}  // namespace

std::vector<Figure> figures_of(const RecordedRun& run, const RunDifferences& differences,
                               const std::optional<Parting>& parting, const RunOutcome& outcome) {
  std::vector<Figure> figures;
  if (run.summary.is_object() && run.summary.contains("probes")) {
    for (const auto& [name, probe] : run.summary["probes"].items()) {
      const auto unit = probe.value("unit", "");
      figures.push_back({name, unit, number(probe, "final")});
      figures.push_back({name + ".min", unit, number(probe, "min")});
      figures.push_back({name + ".max", unit, number(probe, "max")});
    }
  }
  if (differences.impossible.empty()) {
    add_course(figures, "distance", "m", differences, [](const auto& row) { return row.max; });
    add_course(figures, "rms", "m", differences, [](const auto& row) { return row.rms; });
    add_course(figures, "hausdorff", "m", differences,
               [](const auto& row) { return row.hausdorff; });
    for (std::size_t i = 0; i < differences.probes.size(); ++i)
      add_course(figures, "difference." + differences.probes[i], differences.units[i], differences,
                 [i](const auto& row) { return row.probes[i]; });
    const double never = std::numeric_limits<double>::infinity();
    figures.push_back({"parts_at", "s", parting ? parting->time : never});
  }
  if (run.summary.is_object()) {
    figures.push_back({"steps", "", number(run.summary, "steps")});
    figures.push_back({"time", "s", number(run.summary, "time")});
  }
  figures.push_back({"done", "", outcome.status == "done" ? 1.0 : 0.0});
  return figures;
}

}  // namespace deform
