#include <deform/plugin/number_file.h>
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

/// Positions from elsewhere: numbers separated by blanks, tabs or commas; empty lines and what
/// follows # do not count.
class File final : public Shape {
 public:
  File(const Parameters& p, const Setup& setup) : path_(setup.resolve(p.path)) {
    const NumberFile readable(path_);  // or it says why not
  }

  [[nodiscard]] NodeVectors positions(const Eigen::MatrixX2d& parameters,
                                      const Vec2& /*size*/) const override {
    const Index nodes = parameters.rows();
    NodeVectors r(nodes, 3);
    Index row = 0;
    NumberFile file(path_);
    while (const auto numbers = file.next()) {
      if (numbers->size() != 3)
        throw InputError(file.place() + "has " + std::to_string(numbers->size()) +
                         " numbers: x y z are wanted");
      if (row == nodes) reject("more than " + std::to_string(nodes), nodes);
      r.row(row++) << (*numbers)[0], (*numbers)[1], (*numbers)[2];
    }
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
