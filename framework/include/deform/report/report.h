/// Reports: one self-contained page that shows a run or a comparison.
#pragma once

#include <filesystem>

#include "deform/export.h"

namespace deform {

/// Where the page without data is looked for: beside the program, as plugins are; empty when it is
/// not there.
[[nodiscard]] DEFORM_API std::filesystem::path find_report_page();

/// Writes report.html into a run or comparison directory, from nothing but what the directory holds
/// (docs/report-format.md), all at once. Returns the file. What the directory ought to hold and
/// does not, or holds damaged, is warned of and left out. Throws InputError when the folder is
/// neither, a process works in it, or the page to fill in is not found.
DEFORM_API std::filesystem::path write_report(const std::filesystem::path& folder);

/// Writes report.png, a contact sheet (variants × moments) as the page itself draws it, with a
/// headless Chromium; report.html must be there. Returns the file. Throws InputError when there is
/// no Chromium, Error when it fails.
DEFORM_API std::filesystem::path write_contact_sheet(const std::filesystem::path& folder);

}  // namespace deform
