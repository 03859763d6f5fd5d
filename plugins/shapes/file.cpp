#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <string_view>

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
      throw InputError(place + "'" + std::string(word) + "' is not a finite number");
    if (count < 3) row[count] = number;
    ++count;
  }
  if (count != 3)
    throw InputError(place + "has " + std::to_string(count) + " numbers: x y z are wanted");
  return row;
}

/// Positions from elsewhere: numbers separated by blanks, tabs or commas; empty lines and what
/// follows # do not count.
class File final : public Shape {
 public:
  File(const Parameters& p, const Setup& setup) : path_(setup.resolve(p.path)) {
    if (!std::filesystem::is_regular_file(path_))
      throw InputError(path_.string() + ": there is no such file");
    std::ifstream file(path_);
    if (!file) throw InputError(path_.string() + ": cannot be opened");
    std::string line;
    for (int number = 1; std::getline(file, line); ++number) {
      line.resize(std::min(line.find('#'), line.size()));
      if (line.find_first_not_of(" \t\r") == std::string::npos) continue;
      rows_.push_back(parse_row(line, path_.string() + ":" + std::to_string(number) + ": "));
    }
    if (file.bad()) throw InputError(path_.string() + ": cannot be read to its end");
  }

  [[nodiscard]] NodeVectors positions(const Eigen::MatrixX2d& parameters,
                                      const Vec2& /*size*/) const override {
    const auto nodes = static_cast<std::size_t>(parameters.rows());
    if (rows_.size() != nodes)
      throw InputError(path_.string() + ": has " + std::to_string(rows_.size()) +
                       " positions, but the surface has " + std::to_string(nodes) + " nodes");
    NodeVectors r(parameters.rows(), 3);
    for (std::size_t a = 0; a < nodes; ++a) r.row(static_cast<Index>(a)) = rows_[a];
    return r;
  }

 private:
  std::filesystem::path path_;
  std::vector<Vec3> rows_;  // [m]
};

}  // namespace

DEFORM_PLUGIN(File, Parameters, .name = "file", .version = "1.0",
              .summary = "positions from a text file, one line x y z a node", .formula = "",
              .source = "")
