#include <algorithm>
#include <chrono>
#include <string>
#include <string_view>
#include <system_error>

#include <fmt/format.h>

#include "deform/error.h"
#include "deform/report/report.h"

#include "files/files.h"
#include "report/base64.h"
#include "report/chromium.h"

namespace deform {
namespace {

namespace fs = std::filesystem;

/// For sixty variants drawn by a processor that has other things to do.
constexpr std::chrono::seconds kPatience{180};

/// As a browser wants it: what has a meaning in an address is encoded.
std::string address_of(const fs::path& file) {
  std::string address = "file://";
  for (const char character : file.string()) {
    const auto byte = static_cast<unsigned char>(character);
    const bool is_plain = (byte >= '0' && byte <= '9') || (byte >= 'a' && byte <= 'z') ||
                          (byte >= 'A' && byte <= 'Z') ||
                          std::string_view("/-._~").find(character) != std::string_view::npos;
    address += is_plain ? std::string(1, character) : fmt::format("%{:02X}", byte);
  }
  return address;
}

/// What stands between two texts; empty where they are not there.
std::string_view between(std::string_view text, std::string_view before, std::string_view after) {
  const std::size_t found = text.find(before);
  if (found == std::string_view::npos) return {};
  text.remove_prefix(found + before.size());
  return text.substr(0, text.find(after));
}

std::string why_not(std::string_view document) {
  const std::string_view element = between(document, R"(<p class="failure")", "</p>");
  const std::string_view said = element.substr(std::min(element.find('>'), element.size() - 1) + 1);
  return said.empty() ? "the page has not drawn it" : std::string(said);
}

}  // namespace

fs::path write_contact_sheet(const fs::path& folder) {
  const fs::path page = fs::absolute(folder / "report.html");
  std::error_code error;
  if (!fs::is_regular_file(page, error))
    throw InputError(fmt::format("there is no report '{}'", page.string()));
  const fs::path chromium = find_chromium();
  if (chromium.empty()) {
    throw InputError(
        "no Chromium to draw the contact sheet with: install chromium, or set DEFORM_CHROMIUM to "
        "the program");
  }
  const std::string document =
      document_of(chromium, address_of(page) + "#contact-sheet=1", kPatience);
  const std::string_view image = between(document, R"(<img id="contact-sheet")", ">");
  const std::string_view data = between(image, "data:image/png;base64,", "\"");
  if (data.empty()) {
    throw Error(ExitCode::internal_error,
                fmt::format("no contact sheet of {}: {}", page.string(), why_not(document)));
  }
  fs::path file = folder / "report.png";
  write_atomically(file, decode_base64(data));
  return file;
}

}  // namespace deform
