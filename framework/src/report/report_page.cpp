#include "report/report_page.h"

#include <system_error>
#include <utility>

#include <boost/dll/runtime_symbol_info.hpp>

#include "deform/error.h"
#include "deform/report/report.h"

namespace deform {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kBefore = R"(<script id="deform-data" type="application/json">)";
constexpr std::string_view kData = "null";
constexpr std::string_view kAfter = "</script>";

const fs::path kPlace = fs::path(DEFORM_INSTALL_DATADIR) / "deform" / "report.html";

}  // namespace

ReportPage::ReportPage(std::string text) : text_(std::move(text)) {
  const std::string place = std::string(kBefore) + std::string(kData) + std::string(kAfter);
  const std::size_t found = text_.find(place);
  if (found == std::string::npos || text_.find(place, found + 1) != std::string::npos)
    throw InputError("the page for reports does not have one place for the data");
  data_at_ = found + kBefore.size();
}

std::string_view ReportPage::before() const { return std::string_view(text_).substr(0, data_at_); }

std::string_view ReportPage::after() const {
  return std::string_view(text_).substr(data_at_ + kData.size());
}

void append_escaped(std::string& text, std::string_view json) {
  for (;;) {
    const std::size_t end = json.find('<');
    text += json.substr(0, end);
    if (end == std::string_view::npos) return;
    text += "\\u003c";
    json.remove_prefix(end + 1);
  }
}

fs::path find_report_page() {
  std::error_code error;
  const fs::path program = boost::dll::program_location(error);
  if (!error) {
    fs::path page = program.parent_path().parent_path() / kPlace;
    if (fs::is_regular_file(page, error)) return page;
  }
  // The library lies in lib, or a folder of that for the machine's kind.
  const fs::path library = boost::dll::this_line_location(error);
  fs::path prefix = library.parent_path();
  for (int up = 0; up < 2 && prefix.has_relative_path(); ++up) {
    prefix = prefix.parent_path();
    fs::path page = prefix / kPlace;
    if (fs::is_regular_file(page, error)) return page;
  }
  return {};
}

}  // namespace deform
