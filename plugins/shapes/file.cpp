#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <istream>
#include <string_view>
#include <system_error>

#include <deform/surface/shape.h>

namespace {
using namespace deform;

struct Parameters {
  std::filesystem::path path;
  static void declare(Declaration<Parameters>& d) {
    d("path", &Parameters::path, "",
      "text file with a line 'x y z' for each node, in order of the nodes")
        .required();
  }
};

/// A word as a message shows it: not too long, and printable whatever the file holds.
std::string shown(std::string_view word) {
  constexpr std::size_t kMost = 40;
  std::string text(word.substr(0, kMost));
  for (char& c : text)
    if (c < ' ' || c > '~') c = '?';
  return "'" + text + (word.size() > kMost ? "...'" : "'");
}

/// The three numbers [m] of a line without its comment; throws InputError that begins with `place`.
Vec3 parse_row(std::string_view line, const std::string& place) {
  Vec3 row;
  int count = 0;
  constexpr std::string_view separators = " \t\r,";
  while (true) {
    line.remove_prefix(std::min(line.find_first_not_of(separators), line.size()));
    if (line.empty()) break;
    const std::string_view word = line.substr(0, line.find_first_of(separators));
    line.remove_prefix(word.size());
    double number = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), number);
    if (error != std::errc() || end != word.data() + word.size() || !std::isfinite(number))
      throw InputError(place + shown(word) + " is not a finite number");
    if (count < 3) row[count] = number;
    ++count;
  }
  if (count != 3)
    throw InputError(place + "has " + std::to_string(count) + " numbers: x y z are wanted");
  return row;
}

/// The next line without its comment; false at the end of the file. Throws InputError that begins
/// with `place` when there is too much of it: what has no line breaks is no such file, and may be
/// too large for the memory.
bool read_line(std::istream& file, std::string& line, const std::string& place) {
  constexpr std::size_t kMost = 4096;  // [bytes]
  line.clear();
  for (int c = file.get(); c != std::istream::traits_type::eof() && c != '\n'; c = file.get()) {
    if (line.size() == kMost) throw InputError(place + "is longer than 4096 bytes");
    line += static_cast<char>(c);
  }
  const bool any = !file.eof() || !line.empty();
  line.resize(std::min(line.find('#'), line.size()));
  return any;
}

/// Positions from elsewhere: numbers separated by blanks, tabs or commas; empty lines and what
/// follows # do not count.
class File final : public Shape {
 public:
  File(const Parameters& p, const Setup& setup) : path_(setup.resolve(p.path)) {
    std::error_code error;
    const auto status = std::filesystem::status(path_, error);
    if (is_directory(status)) throw InputError(path_.string() + ": is a folder, not a file");
    if (status.type() == std::filesystem::file_type::not_found)
      throw InputError(path_.string() + ": there is no such file");
    if (error) throw InputError(path_.string() + ": cannot be read: " + error.message());
    // Pipes and devices may never end, or never begin.
    if (!is_regular_file(status)) throw InputError(path_.string() + ": is not a regular file");
    if (!std::ifstream(path_)) throw InputError(path_.string() + ": cannot be opened");
  }

  [[nodiscard]] NodeVectors positions(const Eigen::MatrixX2d& parameters,
                                      const Vec2& /*size*/) const override {
    const Index nodes = parameters.rows();
    NodeVectors r(nodes, 3);
    Index row = 0;
    std::ifstream file(path_);
    std::string line;
    for (int number = 1;; ++number) {
      const std::string place = path_.string() + ":" + std::to_string(number) + ": ";
      if (!read_line(file, line, place)) break;
      if (line.find_first_not_of(" \t\r") == std::string::npos) continue;
      const Vec3 position = parse_row(line, place);
      if (row == nodes) reject("more than " + std::to_string(nodes), nodes);
      r.row(row++) = position;
    }
    if (file.bad()) throw InputError(path_.string() + ": cannot be read to its end");
    if (row < nodes) reject(std::to_string(row), nodes);
    return r;
  }

 private:
  [[noreturn]] void reject(const std::string& found, Index nodes) const {
    throw InputError(path_.string() + ": has " + found + " positions, but the surface has " +
                     std::to_string(nodes) + " nodes");
  }

  std::filesystem::path path_;
};

}  // namespace

DEFORM_PLUGIN(File, Parameters, .name = "file", .version = "1.0",
              .summary = "positions from a text file, one line x y z a node", .formula = "",
              .source = "")
