#include "report_command.h"

#include <cstdio>
#include <exception>

#include <fmt/format.h>

#include "deform/error.h"
#include "deform/report/report.h"

#include "interrupt.h"
#include "terminal.h"

namespace deform::app {

int write_reports(const std::filesystem::path& folder, bool png) {
  say("{}\n", write_report(folder).string());
  if (png) say("{}\n", write_contact_sheet(folder).string());
  return static_cast<int>(ExitCode::done);
}

AddedReport add_report(const std::filesystem::path& folder) {
  if (find_report_page().empty())
    return {"none: its page was not built (deform report says more)", ExitCode::done};
  // It may take its time: who interrupts has none.
  if (!end_when_interrupted()) return {"none: deform report makes it", ExitCode::done};
  try {
    return {write_report(folder).string(), ExitCode::done};
  } catch (const Error& e) {
    complain("no report.html: {}", e.what());
    return {"none", e.code()};
  } catch (const std::exception& e) {
    complain("no report.html: {}", e.what());
  }
  return {"none", ExitCode::internal_error};
}

}  // namespace deform::app
