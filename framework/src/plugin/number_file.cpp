#include "deform/plugin/number_file.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <string_view>
#include <system_error>
#include <utility>

#include "deform/error.h"

namespace deform {
namespace {

/// Some files tell no size and have no end (/proc, /sys).
constexpr std::size_t kMostBytes = std::size_t{1} << 30U;

/// A word as a message shows it: not too long, and printable whatever the file holds.
std::string shown(std::string_view word) {
  constexpr std::size_t kMost = 40;
  std::string text(word.substr(0, kMost));
  for (char& c : text)
    if (c < ' ' || c > '~') c = '?';
  return "'" + text + (word.size() > kMost ? "...'" : "'");
}

/// The numbers of a line without its comment; throws InputError that begins with `place`.
std::vector<double> parse_row(std::string_view line, const std::string& place) {
  std::vector<double> row;
  constexpr std::string_view separators = " \t\r,";
  while (true) {
    line.remove_prefix(std::min(line.find_first_not_of(separators), line.size()));
    if (line.empty()) return row;
    const std::string_view word = line.substr(0, line.find_first_of(separators));
    line.remove_prefix(word.size());
    double number = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), number);
    if (error != std::errc() || end != word.data() + word.size() || !std::isfinite(number))
      throw InputError(place + shown(word) + " is not a finite number");
    row.push_back(number);
  }
}

}  // namespace

NumberFile::NumberFile(std::filesystem::path path, std::size_t longest_line)
    : path_(std::move(path)), longest_line_(longest_line) {
  const auto reject = [this](const std::string& why) {
    throw InputError(path_.string() + ": " + why);
  };
  std::error_code error;
  const auto status = std::filesystem::status(path_, error);
  if (is_directory(status)) reject("is a folder, not a file");
  if (status.type() == std::filesystem::file_type::not_found) reject("there is no such file");
  if (error) reject("cannot be read: " + error.message());
  // Pipes and devices may never end, or never begin.
  if (!is_regular_file(status)) reject("is not a regular file");
  file_.open(path_);
  if (!file_) reject("cannot be opened");
}

std::string NumberFile::place() const {
  return path_.string() + ":" + std::to_string(line_) + ": ";
}

bool NumberFile::read_line(std::string& line) {
  ++line_;
  line.clear();
  for (int c = file_.get(); c != std::ifstream::traits_type::eof() && c != '\n'; c = file_.get()) {
    if (line.size() == longest_line_)
      throw InputError(place() + "is longer than " + std::to_string(longest_line_) + " bytes");
    line += static_cast<char>(c);
  }
  if (file_.bad()) throw InputError(path_.string() + ": cannot be read to its end");
  const bool any = !file_.eof() || !line.empty();
  bytes_ += line.size() + 1;
  if (bytes_ > kMostBytes)
    throw InputError(path_.string() + ": is too large, expected at most " +
                     std::to_string(kMostBytes) + " bytes");
  line.resize(std::min(line.find('#'), line.size()));
  return any;
}

std::optional<std::vector<double>> NumberFile::next() {
  std::string line;
  while (read_line(line)) {
    auto row = parse_row(line, place());
    if (!row.empty()) return row;
  }
  return std::nullopt;
}

}  // namespace deform
