#include <array>

#include <fmt/format.h>

#include "deform/error.h"

#include "plugin_command.h"
#include "table.h"
#include "terminal.h"

namespace deform::app {
namespace {

const char* text_of(CheckOutcome outcome) {
  switch (outcome) {
    case CheckOutcome::passed:
      return "passed";
    case CheckOutcome::failed:
      return "FAILED";
    case CheckOutcome::reported:
      return "reported";
  }
  return "";
}

}  // namespace

int check_plugin(const ContractOptions& options) {
  const ContractReport report = check_contract(options);
  say("{}\n\n", report.plugin);
  std::vector<std::vector<std::string>> rows{
      {"check", "figure", "limit", "result", "where worst, or why"}};
  std::array<int, 3> counts{};
  for (const CheckLine& line : report.lines) {
    rows.push_back({line.name, line.figure, line.limit, text_of(line.outcome), line.note});
    ++counts.at(static_cast<std::size_t>(line.outcome));
  }
  print_table(rows);
  say("\n{} passed, {} failed, {} reported\n", counts[0], counts[1], counts[2]);
  return static_cast<int>(report.passed() ? ExitCode::done : ExitCode::expectation_failed);
}

}  // namespace deform::app
