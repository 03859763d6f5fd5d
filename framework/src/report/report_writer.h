/// The data of a report as text: docs/report-format.md.
#pragma once

#include <cstddef>
#include <string>

#include "report/report_source.h"

namespace deform {

/// Figures of all probes together that a report has: a plot is some hundred pixels wide.
inline constexpr std::size_t kMostFigures = 500'000;

/// Appends the JSON text of the report. Mesh, positions and fields take at most `most_bytes`; the
/// report says what was left out for that.
void append_report(std::string& text, const ReportSource& source, std::size_t most_bytes);

}  // namespace deform
