/// deform report
#pragma once

#include <filesystem>
#include <string>

namespace deform::app {

/// Makes report.html of a run or comparison directory again, and report.png where `png` is set;
/// prints their paths. Returns the program's exit code.
[[nodiscard]] int write_reports(const std::filesystem::path& folder, bool png);

/// Makes report.html at the end of a run. That it cannot is a warning, and changes nothing else.
/// Returns what a summary says of it: its path, or why there is none.
[[nodiscard]] std::string add_report(const std::filesystem::path& folder);

}  // namespace deform::app
