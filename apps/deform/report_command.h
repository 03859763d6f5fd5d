/// deform report
#pragma once

#include <filesystem>
#include <string>

#include "deform/error.h"

namespace deform::app {

/// Makes report.html of a run or comparison directory again, and report.png where `png` is set;
/// prints their paths. Returns the program's exit code.
[[nodiscard]] int write_reports(const std::filesystem::path& folder, bool png);

/// What became of the report at the end of a run.
struct AddedReport {
  std::string told;  ///< what a summary says of it: its path, or why there is none
  ExitCode code;     ///< done also where the page was not built: nothing can be done about it then
};

/// Makes report.html at the end of a run; says why where it cannot.
[[nodiscard]] AddedReport add_report(const std::filesystem::path& folder);

}  // namespace deform::app
