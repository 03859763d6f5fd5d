#include "deform/report/report.h"

#include <algorithm>
#include <cstddef>
#include <optional>
#include <string>
#include <system_error>

#include "deform/error.h"
#include "deform/log.h"

#include "files/files.h"
#include "report/report_page.h"
#include "report/report_source.h"
#include "report/report_writer.h"
#include "simulation/folder_lock.h"
#include "simulation/old_run.h"
#include "simulation/run_directory.h"

namespace deform {
namespace {

namespace fs = std::filesystem;

/// A page of 60 MB opens at once; larger ones are no fun to send. Scene, manifests and plots take a
/// part of it that is known only when they are written.
constexpr std::size_t kMostBytes = 60'000'000;
constexpr std::size_t kRoomForText = 3'000'000;
constexpr std::size_t kTextOfVariant = 6'000;
constexpr std::size_t kTextOfFigure = 14;

ReportPage read_page() {
  const fs::path page = find_report_page();
  if (page.empty()) {
    throw InputError(
        "the page for reports is not installed (share/deform/report.html): npm makes it when "
        "deform "
        "is built; install nodejs and npm, then configure and build again");
  }
  return ReportPage(read_file(page).value_or(""));
}

/// What is left for shapes and fields.
std::size_t room(const ReportSource& source, const ReportPage& page) {
  std::size_t other = page.bytes() + kRoomForText + source.verdict.dump().size();
  std::size_t figures = 0;
  for (const ReportVariant& variant : source.variants)
    figures += variant.probe_rows * variant.probe_columns;
  other +=
      source.variants.size() * kTextOfVariant + std::min(figures, kMostFigures) * kTextOfFigure;
  return other < kMostBytes ? kMostBytes - other : 0;
}

}  // namespace

fs::path write_report(const fs::path& folder) {
  require_unheld(folder);
  std::error_code error;
  std::optional<FolderLock> lock;
  if (fs::is_directory(folder, error) && (has_manifest(folder) || has_old_run(folder))) {
    lock.emplace(folder);
    give_old_run_back(folder);
  }
  const ReportSource source = read_report_source(folder);
  for (const std::string& note : source.notes) log::warn(note);
  const ReportPage page = read_page();
  std::string text(page.before());
  append_report(text, source, room(source, page));
  text += page.after();
  fs::path file = folder / "report.html";
  write_atomically(file, text);
  return file;
}

}  // namespace deform
