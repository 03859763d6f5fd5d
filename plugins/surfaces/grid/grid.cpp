#include <algorithm>
#include <cmath>
#include <map>
#include <sstream>
#include <unistd.h>

#include <deform/surface/shape.h>
#include <deform/surface/surface.h>

#include "differences.h"

namespace {
using namespace deform;
using grid::Line;
using grid::Row;

struct Parameters {
  std::array<std::int64_t, 2> nodes{21, 21};
  Vec2 size{1.0, 1.0};
  std::string differences = "forward", border = "one_sided", weights = "area";
  std::array<bool, 2> periodic{false, false};
  PluginUse rest{.kind = PluginKind::shape, .name = "flat"};
  PluginUse initial{.kind = PluginKind::shape, .name = ""};

  static void declare(Declaration<Parameters>& d) {
    d("nodes", &Parameters::nodes, "", "nodes along a1 and a2").required().at_least(3);
    d("size", &Parameters::size, "m", "extent of the parameters a1 and a2").above(0);
    d("differences", &Parameters::differences, "",
      "of r: forward (the paper's D^+), or central: normals of second order, but blind to what "
      "alternates from "
      "node to node, which stretching then does not resist")
        .one_of({"forward", "central"});
    d("border", &Parameters::border, "",
      "paper: differences that leave the grid do not exist; one_sided: the nearest that does not")
        .one_of({"paper", "one_sided"});
    d("weights", &Parameters::weights, "",
      "of nodes and samples: equal, or the area that each stands for (half at the border)")
        .one_of({"equal", "area"});
    d("periodic", &Parameters::periodic, "", "sides that are joined, along a1 and a2");
    d("rest", &Parameters::rest, "", "shape without energy");
    d("initial", &Parameters::initial, "", "shape at first; the rest shape when absent");
  }
};

/// Bytes that a run needs for each node: operators, geometry of three states, matrix and factor.
/// Measured at 513 × 513 nodes: 3.4e3 with bending in its expanded form, 4.0e3 in the other, 4.4e3
/// with bending_variational (at 257 × 257 some 7 % more); mirror_asymmetry, which runs a second
/// sheet, takes four fifths as much again.
constexpr double kBytesPerNode = 4.4e3;

/// Rectangular grid with the paper's differences; its samples are its nodes.
class Grid final : public Surface {
 public:
  Grid(const Parameters& p, const Setup& setup) : n_1_(p.nodes[0]), n_2_(p.nodes[1]) {
    check_size(p);
    make_parameters(p);
    make_areas(p);
    make_faces(p);
    rest_ = positions(p.rest, p.size, setup);
    initial_ = p.initial.name.empty() ? rest_ : positions(p.initial, p.size, setup);
    check_closed(p);
    samples_ = make_samples(p);
  }

  [[nodiscard]] Index nodes() const override { return n_1_ * n_2_; }
  [[nodiscard]] std::vector<std::pair<std::string, std::string>> refinement() const override {
    const auto finer = [](Index n, bool joined) { return joined ? 2 * n : 2 * n - 1; };
    std::ostringstream nodes;
    nodes << '[' << finer(n_1_, periodic_[0]) << ", " << finer(n_2_, periodic_[1]) << ']';
    return {{"/nodes", nodes.str()}};
  }
  [[nodiscard]] const Eigen::MatrixX2d& parameters() const override { return parameters_; }
  [[nodiscard]] Vec2 period() const override {
    return {periodic_[0] ? h_1_ * static_cast<double>(n_1_) : 0.0,
            periodic_[1] ? h_2_ * static_cast<double>(n_2_) : 0.0};
  }
  [[nodiscard]] const NodeValues& areas() const override { return areas_; }
  [[nodiscard]] const NodeVectors& rest() const override { return rest_; }
  [[nodiscard]] const NodeVectors& initial() const override { return initial_; }
  [[nodiscard]] const Faces& faces() const override { return faces_; }
  [[nodiscard]] const SampleSet& samples(SampleRole /*role*/) const override { return *samples_; }

  [[nodiscard]] std::vector<std::string> boundary_names() const override {
    std::vector<std::string> names;
    if (!periodic_[0]) names.insert(names.end(), {"left", "right"});
    if (!periodic_[1]) names.insert(names.end(), {"bottom", "top"});
    return names;
  }
  [[nodiscard]] std::vector<std::string> corner_names() const override {
    if (periodic_[0] || periodic_[1]) return {};
    return {"left_bottom", "right_bottom", "left_top", "right_top"};
  }
  [[nodiscard]] std::vector<Index> boundary(const std::string& name) const override {
    std::vector<Index> result;
    for (Index j = 0; j < n_2_; ++j)
      for (Index i = 0; i < n_1_; ++i)
        if ((name == "left" && i == 0) || (name == "right" && i == n_1_ - 1) ||
            (name == "bottom" && j == 0) || (name == "top" && j == n_2_ - 1))
          result.push_back(node(i, j));
    return result;
  }
  [[nodiscard]] std::vector<Index> corner(const std::string& name) const override {
    const auto names = corner_names();
    const auto at = std::ranges::find(names, name) - names.begin();
    if (at == static_cast<std::ptrdiff_t>(names.size())) return {};
    return {node(at % 2 == 0 ? 0 : n_1_ - 1, at < 2 ? 0 : n_2_ - 1)};
  }

 private:
  [[nodiscard]] Index node(Index i, Index j) const { return i + n_1_ * j; }

  [[noreturn]] static void reject(const std::string& key, const std::string& why) {
    throw InputError({Problem{"/" + key, why}});
  }

  static void check_size(const Parameters& p) {
    const double count = static_cast<double>(p.nodes[0]) * static_cast<double>(p.nodes[1]);
    const double bytes = count * kBytesPerNode;
    const double memory =
        static_cast<double>(sysconf(_SC_PHYS_PAGES)) * static_cast<double>(sysconf(_SC_PAGE_SIZE));
    const std::string grid =
        "a grid of " + std::to_string(p.nodes[0]) + " × " + std::to_string(p.nodes[1]);
    if (count > 2147483647.0)
      reject("nodes", grid + " has more nodes than can be numbered (2^31 − 1)");
    if (bytes > memory)
      reject("nodes", grid + " needs about " + std::to_string(std::llround(bytes / 1e9)) +
                          " GB, this machine has " + std::to_string(std::llround(memory / 1e9)) +
                          " GB");
  }

  /// The operators divide by a cell's sides, twice, and masses are proportional to its area: no
  /// double holds these for sizes beyond all measure.
  void check_cells(const Parameters& p) const {
    const auto check = [&](double h, int direction) {
      if (!std::isnormal(h * h) || !std::isnormal(1 / (h * h)) || !std::isnormal(h_1_ * h_2_))
        reject("size", shown(p.size[direction]) + " m makes cells of " + shown(h_1_) + " × " +
                           shown(h_2_) + " m, too extreme for its differences");
    };
    check(h_1_, 0);
    check(h_2_, 1);
  }
  static std::string shown(double value) {
    std::ostringstream text;
    text << value;
    return text.str();
  }

  void make_parameters(const Parameters& p) {
    periodic_ = p.periodic;
    h_1_ = p.size[0] / static_cast<double>(periodic_[0] ? n_1_ : n_1_ - 1);
    h_2_ = p.size[1] / static_cast<double>(periodic_[1] ? n_2_ : n_2_ - 1);
    check_cells(p);
    parameters_.resize(nodes(), 2);
    for (Index j = 0; j < n_2_; ++j)
      for (Index i = 0; i < n_1_; ++i)
        parameters_.row(node(i, j)) << static_cast<double>(i) * h_1_, static_cast<double>(j) * h_2_;
  }

  void make_areas(const Parameters& p) {
    const auto share = [&](Index i, Index n, bool periodic) {
      return p.weights == "area" && !periodic && (i == 0 || i == n - 1) ? 0.5 : 1.0;
    };
    areas_.resize(nodes());
    for (Index j = 0; j < n_2_; ++j)
      for (Index i = 0; i < n_1_; ++i)
        areas_[node(i, j)] =
            h_1_ * h_2_ * share(i, n_1_, periodic_[0]) * share(j, n_2_, periodic_[1]);
  }

  void make_faces(const Parameters& p) {
    const Index cells_1 = p.periodic[0] ? n_1_ : n_1_ - 1,
                cells_2 = p.periodic[1] ? n_2_ : n_2_ - 1;
    for (Index j = 0; j < cells_2; ++j)
      for (Index i = 0; i < cells_1; ++i) {
        const Index right = (i + 1) % n_1_, above = (j + 1) % n_2_;
        for (const Index corner : {node(i, j), node(right, j), node(right, above), node(i, above)})
          faces_.nodes.push_back(static_cast<std::int32_t>(corner));
        faces_.begin.push_back(static_cast<std::int32_t>(faces_.nodes.size()));
      }
  }

  [[nodiscard]] NodeVectors positions(const PluginUse& use, const Vec2& size,
                                      const Setup& setup) const {
    try {
      return setup.create<Shape>(use)->positions(parameters_, size);
    } catch (const InputError& error) {
      std::vector<Problem> problems = error.problems();
      for (Problem& problem : problems)  // the shape knows not where in the scene it stands
        if (problem.pointer.empty()) problem.pointer = use.pointer;
      throw InputError(std::move(problems));
    }
  }

  /// A shape must close where a side is joined: the seam no longer than three times a neighbouring
  /// cell.
  void check_closed(const Parameters& p) const {
    const auto check = [&](const NodeVectors& r, Index a, Index b, Index c, int direction) {
      const double seam = (r.row(a) - r.row(b)).norm(), cell = (r.row(b) - r.row(c)).norm();
      if (!(seam <= 3 * cell))
        reject("periodic", "the shape does not close along a" + std::to_string(direction) +
                               ": last and first node are " + std::to_string(seam) +
                               " m apart, their cells " + std::to_string(cell) + " m");
    };
    for (const NodeVectors* r : {&rest_, &initial_}) {
      for (Index j = 0; p.periodic[0] && j < n_2_; ++j)
        check(*r, node(0, j), node(n_1_ - 1, j), node(n_1_ - 2, j), 1);
      for (Index i = 0; p.periodic[1] && i < n_1_; ++i)
        check(*r, node(i, 0), node(i, n_2_ - 1), node(i, n_2_ - 2), 2);
    }
  }

  [[nodiscard]] std::unique_ptr<SampleSet> make_samples(const Parameters& p) const {
    const auto scheme = p.differences == "forward" ? grid::Scheme::forward : grid::Scheme::central;
    const auto border = p.border == "paper" ? grid::Border::paper : grid::Border::one_sided;
    const Line line_1 = grid::make_line(n_1_, h_1_, periodic_[0], scheme, border);
    const Line line_2 = grid::make_line(n_2_, h_2_, periodic_[1], scheme, border);
    SampleSet::Builder builder(nodes());
    for (Index j = 0; j < n_2_; ++j)
      for (Index i = 0; i < n_1_; ++i) builder.add(sample(i, j, line_1, line_2));
    builder.set_field_differences(field_differences(line_1, line_2));
    return std::make_unique<SampleSet>(builder.build());
  }

  /// The six operators at node (i, j): D_1 and D_11 along its row, D_2 and D_22 along its column,
  /// D_12 = D_1 D_2.
  [[nodiscard]] SampleStencil sample(Index i, Index j, const Line& line_1,
                                     const Line& line_2) const {
    SampleStencil s;
    s.weight = areas_[node(i, j)];
    s.parameter = parameters_.row(node(i, j));
    std::map<Index, std::array<double, kDerivatives>> entries;
    const auto put = [&](Derivative d, const Row& row_1, const Row& row_2) {
      for (const auto& [b, c_2] : row_2)
        for (const auto& [a, c_1] : row_1)
          entries[node(a, b)][static_cast<std::size_t>(slot(d))] += c_1 * c_2;
      s.computable.set(static_cast<std::size_t>(slot(d)), !row_1.empty() && !row_2.empty());
    };
    const auto k = static_cast<std::size_t>(i), l = static_cast<std::size_t>(j);
    const Row here_1{{i, 1.0}}, here_2{{j, 1.0}};
    put(Derivative::d0, here_1, here_2);
    put(Derivative::d1, line_1.d[k], here_2);
    put(Derivative::d2, here_1, line_2.d[l]);
    put(Derivative::d11, line_1.dd[k], here_2);
    put(Derivative::d12, line_1.d[k], line_2.d[l]);
    put(Derivative::d22, here_1, line_2.dd[l]);
    for (const auto& [at, d] : entries) s.entries.push_back({at, d});

    // Where r_1 or r_2 does not exist the normal is taken from central (at the border one-sided)
    // tangents.
    if (line_1.d[k].empty() || line_2.d[l].empty()) {
      std::map<Index, std::array<double, 2>> frame;
      for (const auto& [a, c] : line_1.frame[k]) frame[node(a, j)][0] += c;
      for (const auto& [b, c] : line_2.frame[l]) frame[node(i, b)][1] += c;
      for (const auto& [at, d] : frame) s.frame.push_back({at, d});
    }
    return s;
  }

  [[nodiscard]] FieldDifferences field_differences(const Line& line_1, const Line& line_2) const {
    FieldDifferences::Rows rows;
    for (auto& operator_rows : rows) operator_rows.resize(static_cast<std::size_t>(nodes()));
    for (Index j = 0; j < n_2_; ++j)
      for (Index i = 0; i < n_1_; ++i) {
        const auto put = [&](Derivative d, const Row& row_1, const Row& row_2) {
          auto& row = rows[static_cast<std::size_t>(slot(d))][static_cast<std::size_t>(node(i, j))];
          for (const auto& [b, c_2] : row_2)
            for (const auto& [a, c_1] : row_1) row.push_back({node(a, b), c_1 * c_2});
        };
        const auto k = static_cast<std::size_t>(i), l = static_cast<std::size_t>(j);
        const Row here_1{{i, 1.0}}, here_2{{j, 1.0}};
        put(Derivative::d1, line_1.minus[k], here_2);
        put(Derivative::d2, here_1, line_2.minus[l]);
        put(Derivative::d11, line_1.dd[k], here_2);
        put(Derivative::d12, line_1.minus[k], line_2.minus[l]);
        put(Derivative::d22, here_1, line_2.dd[l]);
      }
    return FieldDifferences(rows);
  }

  Index n_1_, n_2_;
  double h_1_ = 0, h_2_ = 0;
  std::array<bool, 2> periodic_{};
  Eigen::MatrixX2d parameters_;
  NodeValues areas_;
  NodeVectors rest_, initial_;
  Faces faces_;
  std::unique_ptr<SampleSet> samples_;
};

}  // namespace

DEFORM_PLUGIN(Grid, Parameters, .name = "grid", .version = "1.0",
              .summary = "rectangular grid with the paper's or central differences",
              .formula = "D_i^+ r = (r(a + h_i) − r(a))/h_i, D_ii = D_i^- D_i^+, D_12 = D_1 D_2",
              .source = "Terzopoulos et al. 1987; Wu & Melo, section 4")
