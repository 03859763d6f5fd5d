#include "report/report_source.h"

#include <algorithm>
#include <system_error>

#include <fmt/format.h>

#include "deform/error.h"

#include "json/json_file.h"
#include "simulation/manifest.h"
#include "simulation/run_directory.h"

namespace deform {
namespace {

namespace fs = std::filesystem;

std::string text_of(const Json& object, const char* key, const std::string& otherwise = "") {
  const auto found = object.find(key);
  return found != object.end() && found->is_string() ? found->get<std::string>() : otherwise;
}

Json value_of(const Json& object, const char* key, const Json& otherwise = nullptr) {
  const auto found = object.find(key);
  return found != object.end() ? *found : otherwise;
}

/// "2026-01-31T12:00:00Z" as people read it; anything else as it is.
std::string readable(std::string time) {
  if (time.size() == 20 && time[10] == 'T' && time[19] == 'Z')
    return fmt::format("{} {} UTC", time.substr(0, 10), time.substr(11, 5));
  return time;
}

/// What a run has not written itself is not shown as its result.
void add_recorded(ReportVariant& variant, std::vector<std::string>& notes) {
  RecordedRun run = read_variant(variant.folder, notes);
  // One that came to a result has left its manifest, by which the other files are known.
  if ((variant.status == "done" || variant.status == "diverged") && run.manifest.is_null())
    notes.push_back(fmt::format("nothing is known of what {} held: its {} is not there",
                                variant.folder.string(), kManifestFile));
  bool has_states = true;
  for (const DamagedResult& damaged : damaged_results(variant.folder, run.manifest)) {
    notes.push_back(fmt::format("nothing is shown of {}: {}",
                                (variant.folder / damaged.file).string(), damaged.why));
    if (damaged.file == kTrajectoryFile || damaged.file.empty()) has_states = false;
    // The names of the columns are those of the summary.
    if (damaged.file != kTrajectoryFile) variant.has_probes = false;
  }
  if (variant.has_probes) {
    variant.probe_rows = run.probes.moments.size();
    variant.probe_columns = run.probes.names.size() + 2;
  }
  if (run.trajectory && has_states) {
    variant.moments = run.trajectory->moments();
    variant.fields = run.trajectory->fields();
  }
}

ReportVariant single_variant(const fs::path& folder, const Json& manifest) {
  ReportVariant variant;
  variant.folder = folder;
  variant.name = fs::absolute(folder).lexically_normal().filename().string();
  if (variant.name.empty()) variant.name = "run";
  variant.status = text_of(manifest, "status", "failed");
  variant.reason = text_of(manifest, "reason");
  if (variant.status == "running")
    variant.reason = "the run goes on, or was killed: it has not said how it ended";
  return variant;
}

ReportSource read_run_source(const fs::path& folder, const Json& manifest) {
  ReportSource source;
  source.kind = "run";
  source.title = text_of(manifest, "title", "run");
  source.created = readable(text_of(manifest, "started"));
  source.scene = read_json_object(folder / "scene.json");
  if (source.scene.is_null())
    source.notes.push_back(
        fmt::format("nothing is shown of the scene: {} is not there, or no scene",
                    (folder / "scene.json").string()));
  source.variants.push_back(single_variant(folder, manifest));
  return source;
}

/// "", or why a name that a summary says is none of a folder within the comparison's: a summary
/// that somebody wrote must not make the report read files from elsewhere.
std::string outside(const fs::path& folder, const std::string& name) {
  std::error_code error;
  if (name.empty() || name == "." || name == ".." || fs::path(name).filename() != name)
    return fmt::format("summary.json names its folder \"{}\", which is none within '{}'", name,
                       folder.string());
  if (fs::is_symlink(fs::symlink_status(folder / name, error)))
    return fmt::format("{} is a link, out of the comparison directory", (folder / name).string());
  return "";
}

ReportVariant compared_variant(const fs::path& folder, const Json& said,
                               std::vector<std::string>& notes) {
  ReportVariant variant;
  variant.name = text_of(said, "name");
  const std::string name = text_of(said, "folder", variant.name);
  if (const std::string why = outside(folder, name); why.empty())
    variant.folder = folder / name;
  else
    notes.push_back(fmt::format("nothing is shown of \"{}\": {}", variant.name, why));
  variant.status = text_of(said, "status", "failed");
  variant.reason = text_of(said, "reason");
  variant.changes = value_of(said, "changes", Json::array());
  variant.dropped = value_of(said, "dropped", Json::array());
  variant.parts = value_of(said, "parts");
  variant.not_measured = text_of(said, "not_measured");
  return variant;
}

ReportSource read_comparison_source(const fs::path& folder, const Json& summary,
                                    const Json& manifest) {
  ReportSource source;
  source.kind = "comparison";
  source.title = text_of(summary, "title", "comparison");
  source.created = readable(text_of(summary, "created", text_of(manifest, "written")));
  source.scene = value_of(summary, "scene");
  source.reference = value_of(summary, "reference");
  source.tolerance = value_of(summary, "tolerance");
  source.verdict = value_of(summary, "verdict");
  for (const Json& said : value_of(summary, "variants", Json::array())) {
    if (said.is_object()) source.variants.push_back(compared_variant(folder, said, source.notes));
  }
  const bool is_one = std::ranges::any_of(
      source.variants, [&](const ReportVariant& v) { return source.reference == v.name; });
  if (!is_one) source.reference = nullptr;
  return source;
}

}  // namespace

RecordedRun read_variant(const fs::path& folder, std::vector<std::string>& notes) {
  const auto note = [&](const InputError& e) {
    notes.push_back(fmt::format("nothing is shown of {}: {}", folder.string(), e.what()));
  };
  RecordedRun run;
  try {
    run = read_tables(folder);
  } catch (const InputError& e) {
    note(e);
    run.folder = folder;
    run.manifest = read_json_object(folder / "manifest.json");
    return run;
  }
  try {
    open_trajectory(run);
  } catch (const InputError& e) {
    note(e);
  }
  return run;
}

ReportSource read_report_source(const fs::path& folder) {
  std::error_code error;
  if (!fs::is_directory(folder, error))
    throw InputError(fmt::format("'{}' is {}", folder.string(),
                                 fs::exists(folder, error) ? "not a folder" : "not there"));
  const Json summary = read_json_object(folder / "summary.json");
  const Json manifest = read_json_object(folder / "manifest.json");
  const bool is_comparison = text_of(summary, "kind") == "comparison";
  if (!is_comparison && text_of(manifest, "kind") == "comparison") {
    throw InputError(fmt::format(
        "the comparison in '{}' has not come to its end: deform compare --resume goes on with it",
        folder.string()));
  }
  if (!is_comparison && !has_manifest(folder)) {
    throw InputError(fmt::format(
        "'{}' is neither a run directory nor a comparison directory of deform", folder.string()));
  }
  ReportSource source = is_comparison ? read_comparison_source(folder, summary, manifest)
                                      : read_run_source(folder, manifest);
  for (ReportVariant& variant : source.variants)
    if (!variant.folder.empty()) add_recorded(variant, source.notes);
  return source;
}

}  // namespace deform
