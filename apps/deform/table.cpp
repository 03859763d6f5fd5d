#include "table.h"

#include <algorithm>
#include <sstream>
#include <unistd.h>

#include <fmt/format.h>
#include <sys/ioctl.h>

#include "terminal.h"

namespace deform::app {
namespace {

/// Columns that a line has; without end where nobody looks at a terminal.
std::size_t terminal_width() {
  winsize size{};
  const bool is_known = ::ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0;
  return is_known ? size.ws_col : 1'000'000;
}

/// Of a text that is wrapped.
constexpr std::size_t kNarrowest = 24;

bool is_used(const std::vector<std::vector<std::string>>& rows, std::size_t column) {
  return std::any_of(rows.begin() + 1, rows.end(),
                     [column](const auto& row) { return !row[column].empty(); });
}

}  // namespace

std::size_t width_of(const std::string& text) {
  return static_cast<std::size_t>(
      std::count_if(text.begin(), text.end(), [](char byte) {  // those that continue none
        return (static_cast<unsigned char>(byte) & 0xC0U) != 0x80U;
      }));
}

void print_table(const std::vector<std::vector<std::string>>& raw) {
  // Widths are those of what is shown. The last column is wrapped, word by word.
  std::vector<std::vector<std::string>> rows = raw;
  for (auto& row : rows)
    for (std::size_t c = 0; c + 1 < row.size(); ++c) row[c] = printable(row[c]);
  std::vector<std::size_t> columns, widths;
  for (std::size_t c = 0; c < rows.front().size(); ++c) {
    if (!is_used(rows, c)) continue;
    columns.push_back(c);
    widths.push_back(0);
    for (const auto& row : rows) widths.back() = std::max(widths.back(), width_of(row[c]));
  }
  for (const auto& row : rows) {
    std::string front;
    for (std::size_t i = 0; i + 1 < columns.size(); ++i) {
      const std::string& text = row[columns[i]];
      front += "  " + text + std::string(widths[i] - width_of(text), ' ');
    }
    print_wrapped(front + "  ", row[columns.back()]);
  }
}

void print_wrapped(const std::string& front, const std::string& text, std::size_t width) {
  const std::string shown_front = printable(front);
  const std::size_t indent = width_of(shown_front);
  const std::size_t room =
      std::max(std::min(terminal_width(), width), indent + kNarrowest) - indent;
  std::string line = shown_front;
  std::size_t used = 0;
  std::istringstream words(text);
  for (std::string word; words >> word;) {
    word = printable(word);
    if (used > 0 && used + 1 + width_of(word) > room) {
      put_result(line + '\n');
      line = std::string(indent, ' ');
      used = 0;
    }
    line += (used > 0 ? " " : "") + word;
    used += (used > 0 ? 1 : 0) + width_of(word);
  }
  line.erase(line.find_last_not_of(' ') + 1);
  put_result(line + '\n');
}

}  // namespace deform::app
