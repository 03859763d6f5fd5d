#include "compare/comparison_files.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

#include <fmt/format.h>

#include "deform/version.h"

#include "compare/verdict.h"
#include "json/json.h"
#include "simulation/manifest.h"
#include "simulation/probe_table.h"
#include "simulation/scene_files.h"

namespace deform {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

void add_number(std::string& row, double value) {
  row += ',';
  if (!std::isnan(value)) fmt::format_to(std::back_inserter(row), "{}", value);
}

/// Columns of differences of probes that any run has, in the order in which they come up.
std::vector<ProbeColumn> difference_columns(const std::vector<MeasuredRun>& measured) {
  std::vector<ProbeColumn> columns;
  for (const MeasuredRun& run : measured) {
    for (std::size_t i = 0; i < run.differences.probes.size(); ++i) {
      const std::string& name = run.differences.probes[i];
      if (std::ranges::find(columns, name, &ProbeColumn::name) == columns.end())
        columns.push_back({name, run.differences.units[i]});
    }
  }
  return columns;
}

double of_manifest(const Json& manifest, const char* section, const char* key) {
  if (!manifest.is_object()) return kNone;
  const Json& from = *section == '\0' ? manifest : manifest.value(section, Json::object());
  return from.contains(key) && from[key].is_number() ? from[key].get<double>() : kNone;
}

double steps_timed(const RecordedRun& run) { return of_manifest(run.manifest, "", "steps_timed"); }

Json json_of(const std::optional<Parting>& parting) {
  if (!parting) return nullptr;
  return {{"step", parting->step},
          {"time", parting->time},
          {"where", {parting->where.x(), parting->where.y()}},
          {"node", parting->node},
          {"distance", parting->distance}};
}

Json figures_json(const std::vector<Figure>& figures) {
  Json json = Json::object();
  for (const Figure& figure : figures)
    json[figure.name] = {{"value", std::isfinite(figure.value) ? Json(figure.value) : Json()},
                         {"unit", figure.unit}};
  return json;
}

Json changes_json(const Scene& scene) {
  Json changes = Json::array();
  for (const Replacement& change : scene.changes) {
    Json value = Json::parse(change.value, nullptr, false);
    if (value.is_discarded()) value = change.value;
    changes.push_back({{"pointer", change.pointer}, {"value", std::move(value)}});
  }
  return changes;
}

std::string dump(const Json& json) {
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + '\n';
}

}  // namespace

double ms_per_step(const RecordedRun& run) {
  const double steps = steps_timed(run);
  return steps > 0 ? 1e3 * of_manifest(run.manifest, "seconds", "all_steps") / steps : kNone;
}

std::string comparison_csv(const Comparison& comparison, const std::vector<MeasuredRun>& measured) {
  const std::vector<ProbeColumn> columns = difference_columns(measured);
  std::string csv = "run,step,time [s],rms [m],max [m],node,a1 [m],a2 [m],hausdorff [m]";
  for (const ProbeColumn& column : columns)
    csv += ',' + csv_field("difference of " + header_of(column));
  csv += '\n';
  for (std::size_t i = 0; i < measured.size(); ++i) {
    const RunDifferences& differences = measured[i].differences;
    for (const Difference& row : differences.rows) {
      fmt::format_to(std::back_inserter(csv), "{},{}", csv_field(comparison.runs[i].name),
                     row.moment.step);
      for (const double value : {row.moment.time, row.rms, row.max}) add_number(csv, value);
      fmt::format_to(std::back_inserter(csv), ",{}", row.node);
      for (const double value : {row.where.x(), row.where.y(), row.hausdorff})
        add_number(csv, value);
      for (const ProbeColumn& column : columns) {
        const auto found = std::ranges::find(differences.probes, column.name);
        add_number(csv,
                   found == differences.probes.end()
                       ? kNone
                       : row.probes[static_cast<std::size_t>(found - differences.probes.begin())]);
      }
      csv += '\n';
    }
  }
  return csv;
}

std::string cost_csv(const Comparison& comparison, const std::vector<MeasuredRun>& measured) {
  std::string csv = "run,status,steps,wall time [s],step [ms]";
  const auto parts = {"geometry", "assembly", "factorisation", "solve", "output"};
  for (const char* part : parts) fmt::format_to(std::back_inserter(csv), ",{} [ms]", part);
  csv += ",peak memory [MB]\n";
  for (std::size_t i = 0; i < measured.size(); ++i) {
    const RecordedRun& run = measured[i].recorded;
    csv += csv_field(comparison.runs[i].name) + ',' + csv_field(comparison.runs[i].outcome.status);
    add_number(csv, of_manifest(run.manifest, "", "steps"));
    add_number(csv, of_manifest(run.manifest, "", "wall_seconds"));
    add_number(csv, ms_per_step(run));
    for (const char* part : parts)
      add_number(csv, 1e3 * of_manifest(run.manifest, "seconds", part) / steps_timed(run));
    add_number(csv, of_manifest(run.manifest, "", "peak_memory_MB"));
    csv += '\n';
  }
  return csv;
}

std::string summary_json(const Comparison& comparison, const ComparisonPlan& plan,
                         const std::filesystem::path& folder) {
  Json json = {{"kind", "comparison"},
               {"title", plan.runs.front().scene.title},
               {"reference", comparison.reference},
               {"planned_reference", comparison.planned_reference},
               {"tolerance", {{"value", comparison.tolerance}, {"unit", "m"}}},
               {"verdict", verdict_json(comparison)},
               {"claims", Json::array()},
               {"variants", Json::array()}};
  for (const Claim& claim : comparison.claims)
    json["claims"].push_back(
        {{"claim", claim.text}, {"holds", claim.holds}, {"figures", claim.explanation}});
  for (std::size_t i = 0; i < comparison.runs.size(); ++i) {
    const RunComparison& run = comparison.runs[i];
    json["variants"].push_back({{"name", run.name},
                                {"folder", run.name},
                                {"status", run.outcome.status},
                                {"reason", run.outcome.reason},
                                {"changes", changes_json(plan.runs[i].scene)},
                                {"dropped", run.dropped},
                                {"same_as", run.same_as},
                                {"not_measured", run.impossible},
                                {"parts", json_of(run.parting)},
                                {"figures", figures_json(run.figures)}});
  }
  json["scene"] = Json::parse(scene_text(plan.base, plan.base_files, folder));
  return dump(json);
}

std::string manifest_json(const ComparisonOptions& options, const ComparisonPlan& plan,
                          const std::string& status) {
  Json json = {{"program", "deform"},
               {"version", version()},
               {"commit", options.commit.empty() ? Json() : Json(options.commit)},
               {"kind", "comparison"},
               {"status", status},
               {"title", plan.runs.front().scene.title},
               {"scene", std::filesystem::absolute(options.request.scene).string()},
               {"command_line", options.command_line},
               {"written", utc_now()},
               {"jobs", options.runner.jobs},
               {"runs", Json::array()}};
  for (const PlannedRun& run : plan.runs) json["runs"].push_back(run.name);
  return dump(json);
}

}  // namespace deform
