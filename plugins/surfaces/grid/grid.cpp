#include <algorithm>
#include <cmath>
#include <optional>
#include <sstream>
#include <unistd.h>

#include <deform/surface/shape.h>
#include <deform/surface/surface.h>

#include "coarsening.h"
#include "corner_samples.h"
#include "edges.h"
#include "lattice.h"
#include "node_samples.h"
#include "patches.h"
#include "rest_areas.h"

namespace {
using namespace deform;

struct Parameters {
  std::array<std::int64_t, 2> nodes{21, 21};
  Vec2 size{1.0, 1.0};
  std::string differences = "symmetric", border = "one_sided", weights = "area";
  std::array<bool, 2> periodic{false, false};
  PluginUse rest{.kind = PluginKind::shape, .name = "flat"};
  PluginUse initial{.kind = PluginKind::shape, .name = ""};

  static void declare(Declaration<Parameters>& d) {
    d("nodes", &Parameters::nodes, "", "nodes along a1 and a2").required().at_least(3);
    d("size", &Parameters::size, "m", "extent of the parameters a1 and a2").above(0);
    d("differences", &Parameters::differences, "",
      "of r: symmetric (stretching at the four corners of every cell, bending by central "
      "differences at the nodes, both of second order), forward (the paper's D^+), or central: "
      "normals of second order, but blind to what alternates from node to node, which stretching "
      "then does not resist")
        .one_of({"symmetric", "forward", "central"});
    d("border", &Parameters::border, "",
      "paper: differences that leave the grid do not exist; one_sided: the nearest that does not "
      "(symmetric differences need it)")
        .one_of({"paper", "one_sided"});
    d("weights", &Parameters::weights, "",
      "of nodes and samples: equal, or the area that each stands for, half at the border "
      "(symmetric differences need it)")
        .one_of({"equal", "area"});
    d("periodic", &Parameters::periodic, "", "sides that are joined, along a1 and a2");
    d("rest", &Parameters::rest, "", "shape without energy");
    d("initial", &Parameters::initial, "", "shape at first; the rest shape when absent");
  }
};

/// Bytes that a run needs for each node: operators, geometry of three states, matrix and factor.
/// Measured at 513 × 513 nodes with the paper's differences: 3.4e3 with bending in its expanded
/// form, 4.0e3 in the other, 4.4e3 with bending_variational (at 257 × 257 some 7 % more); with the
/// symmetric ones, whose four corner samples a node have a geometry, too, 9.2e3, 9.9e3 and 10.3e3.
/// mirror_asymmetry, which runs a second sheet, takes four fifths as much again.
double bytes_per_node(const Parameters& p) { return p.differences == "symmetric" ? 10.3e3 : 4.4e3; }

/// Rectangular grid: its bending samples are its nodes, its membrane samples, too, unless its
/// differences are symmetric.
class Grid final : public Surface {
 public:
  Grid(const Parameters& p, const Setup& setup) {
    check_size(p);
    check_choices(p);
    lattice_ = make_lattice(p);
    check_cells(p);
    parameters_ = grid::parameters(lattice_);
    weights_ = p.weights == "area" ? grid::Weights::area : grid::Weights::equal;
    areas_ = grid::areas(lattice_, weights_);
    faces_ = grid::faces(lattice_);
    rest_ = positions(p.rest, p.size, setup);
    initial_ = p.initial.name.empty() ? rest_ : positions(p.initial, p.size, setup);
    check_closed(p);
    rest_areas_ = grid::rest_areas(lattice_, areas_, rest_);
    make_samples(p);
  }

  [[nodiscard]] Index nodes() const override { return lattice_.nodes(); }
  [[nodiscard]] std::vector<std::pair<std::string, std::string>> refinement() const override {
    const auto finer = [](Index n, bool joined) { return joined ? 2 * n : 2 * n - 1; };
    std::ostringstream nodes;
    const auto& [n, h, joined] = lattice_;
    nodes << '[' << finer(n[0], joined[0]) << ", " << finer(n[1], joined[1]) << ']';
    return {{"/nodes", nodes.str()}};
  }
  [[nodiscard]] const Eigen::MatrixX2d& parameters() const override { return parameters_; }
  [[nodiscard]] Vec2 period() const override {
    const auto length = [this](std::size_t k) {
      return lattice_.periodic[k] ? lattice_.h[k] * static_cast<double>(lattice_.n[k]) : 0.0;
    };
    return {length(0), length(1)};
  }
  [[nodiscard]] const NodeValues& areas() const override { return areas_; }
  [[nodiscard]] NodeValues rest_areas() const override { return rest_areas_; }
  /// Where all nodes weigh the same, a node is in a patch or not, as in the paper.
  [[nodiscard]] NodeValues areas_within(
      const std::vector<ParameterRectangle>& rectangles) const override {
    return weights_ == grid::Weights::area ? grid::areas_within(lattice_, rectangles)
                                           : Surface::areas_within(rectangles);
  }
  [[nodiscard]] const NodeVectors& rest() const override { return rest_; }
  [[nodiscard]] const NodeVectors& initial() const override { return initial_; }
  [[nodiscard]] const Faces& faces() const override { return faces_; }
  [[nodiscard]] const SampleSet& samples(SampleRole role) const override {
    return role == SampleRole::membrane && corner_samples_ ? *corner_samples_ : *node_samples_;
  }

  [[nodiscard]] std::vector<std::string> boundary_names() const override {
    std::vector<std::string> names;
    if (!lattice_.periodic[0]) names.insert(names.end(), {"left", "right"});
    if (!lattice_.periodic[1]) names.insert(names.end(), {"bottom", "top"});
    return names;
  }
  [[nodiscard]] std::vector<std::string> corner_names() const override {
    if (lattice_.periodic[0] || lattice_.periodic[1]) return {};
    return {"left_bottom", "right_bottom", "left_top", "right_top"};
  }
  [[nodiscard]] std::vector<Index> boundary(const std::string& name) const override {
    return grid::side(lattice_, name);
  }
  [[nodiscard]] std::vector<Index> corner(const std::string& name) const override {
    const auto names = corner_names();
    const auto at = std::ranges::find(names, name) - names.begin();
    if (at == static_cast<std::ptrdiff_t>(names.size())) return {};
    return {lattice_.node(at % 2 == 0 ? 0 : lattice_.n[0] - 1, at < 2 ? 0 : lattice_.n[1] - 1)};
  }
  [[nodiscard]] std::vector<EdgeNode> edge(const std::string& name) const override {
    return grid::edge(lattice_, rest_, name);
  }
  [[nodiscard]] std::vector<Prolongation> coarsening() const override {
    return grid::coarsening(lattice_, grid::Interpolation::linear);
  }
  [[nodiscard]] std::vector<Prolongation> smooth_coarsening() const override {
    return grid::coarsening(lattice_, grid::Interpolation::smooth);
  }

 private:
  [[noreturn]] static void reject(const std::string& key, const std::string& why) {
    throw InputError({Problem{"/" + key, why}});
  }

  static void check_size(const Parameters& p) {
    const double count = static_cast<double>(p.nodes[0]) * static_cast<double>(p.nodes[1]);
    const double bytes = count * bytes_per_node(p);
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

  /// Border and weights on which the symmetric differences' order rests.
  static void check_choices(const Parameters& p) {
    if (p.differences != "symmetric") return;
    std::vector<Problem> problems;
    if (p.border != "one_sided")
      problems.push_back({"/border", "found \"" + p.border +
                                         "\", expected \"one_sided\": symmetric differences "
                                         "are of second order at the border, too"});
    if (p.weights != "area")
      problems.push_back({"/weights", "found \"" + p.weights +
                                          "\", expected \"area\": with symmetric differences "
                                          "each sample stands for the area around it"});
    if (!problems.empty()) throw InputError(std::move(problems));
  }

  static grid::Lattice make_lattice(const Parameters& p) {
    grid::Lattice lattice{.n = {p.nodes[0], p.nodes[1]}, .h = {}, .periodic = p.periodic};
    for (const std::size_t k : {std::size_t{0}, std::size_t{1}})
      lattice.h[k] = p.size[static_cast<Index>(k)] / static_cast<double>(lattice.cells(k));
    return lattice;
  }

  /// The operators divide by a cell's sides, twice, and masses are proportional to its area: no
  /// double holds these for sizes beyond all measure.
  void check_cells(const Parameters& p) const {
    const auto& h = lattice_.h;
    for (const std::size_t k : {std::size_t{0}, std::size_t{1}})
      if (!std::isnormal(h[k] * h[k]) || !std::isnormal(1 / (h[k] * h[k])) ||
          !std::isnormal(h[0] * h[1]))
        reject("size", shown(p.size[static_cast<Index>(k)]) + " m makes cells of " + shown(h[0]) +
                           " × " + shown(h[1]) + " m, too extreme for its differences");
  }
  static std::string shown(double value) {
    std::ostringstream text;
    text << value;
    return text.str();
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
    const auto& [n, h, joined] = lattice_;
    const auto at = [this](Index i, Index j) { return lattice_.node(i, j); };
    for (const NodeVectors* r : {&rest_, &initial_}) {
      for (Index j = 0; p.periodic[0] && j < n[1]; ++j)
        check(*r, at(0, j), at(n[0] - 1, j), at(n[0] - 2, j), 1);
      for (Index i = 0; p.periodic[1] && i < n[0]; ++i)
        check(*r, at(i, 0), at(i, n[1] - 1), at(i, n[1] - 2), 2);
    }
  }

  void make_samples(const Parameters& p) {
    const auto scheme = p.differences == "forward" ? grid::Scheme::forward : grid::Scheme::central;
    const auto border = p.border == "paper" ? grid::Border::paper : grid::Border::one_sided;
    node_samples_ = grid::node_samples(lattice_, scheme, border, areas_);
    if (p.differences == "symmetric") corner_samples_ = grid::corner_samples(lattice_);
  }

  grid::Lattice lattice_;
  Eigen::MatrixX2d parameters_;
  grid::Weights weights_ = grid::Weights::area;
  NodeValues areas_, rest_areas_;
  NodeVectors rest_, initial_;
  Faces faces_;
  std::optional<SampleSet> node_samples_, corner_samples_;
};

}  // namespace

DEFORM_PLUGIN(
    Grid, Parameters, .name = "grid", .version = "1.0",
    .summary = "rectangular grid with symmetric (second order), the paper's or central differences",
    .formula = "D_i^+ r = (r(a + h_i) − r(a))/h_i, D_ii = D_i^- D_i^+, D_12 = D_1 D_2",
    .source = "Terzopoulos et al. 1987; Wu & Melo, section 4")
