/// What a run or comparison directory holds for a report.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "deform/record/trajectory.h"

#include "compare/recorded_run.h"
#include "json/json.h"

namespace deform {

struct ReportVariant {
  std::string name;
  std::filesystem::path folder;  ///< empty: there is none to look into
  std::string status, reason;
  Json changes = Json::array();  ///< against the base scene
  Json dropped = Json::array();  ///< pointers of parameters that a changed plugin does not have
  Json parts;                    ///< null, or where it leaves the reference
  std::string not_measured;      ///< why it was not measured against the reference; empty: it was
  std::vector<Moment> moments;   ///< of its trajectory; empty where there is none
  std::vector<TrajectoryField> fields;
  std::size_t probe_rows = 0, probe_columns = 0;
  bool has_probes = true;  ///< false: its figures are not those that the run has written
};

struct ReportSource {
  std::string kind;  ///< "run" or "comparison"
  std::string title, created;
  Json scene;
  Json reference, tolerance, verdict;  ///< null in a run
  std::vector<ReportVariant> variants;
  std::vector<std::string> notes;  ///< about what cannot be read, or is not there
};

/// Throws InputError when the folder is neither a run nor a comparison directory. What is wrong
/// with one variant's files is a note, and that variant is then without what they hold.
[[nodiscard]] ReportSource read_report_source(const std::filesystem::path& folder);

/// The variant's files; those that cannot be read are left out, with a sentence in `notes`.
[[nodiscard]] RecordedRun read_variant(const std::filesystem::path& folder,
                                       std::vector<std::string>& notes);

}  // namespace deform
