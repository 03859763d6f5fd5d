/// A surface without difference operators, for tests of what needs only nodes, areas, faces and
/// selections.
#pragma once

#include <string>
#include <vector>

#include "deform/surface/surface.h"

namespace deform::test {

/// Nodes in rows along a1, `columns` × `rows`, spacing 1/(columns − 1) both ways; flat at rest.
/// Nodes on a side of the rectangle have half the area of inner ones, those in its corners a
/// quarter.
class FakeSurface : public Surface {
 public:
  FakeSurface(Index columns, Index rows)
      : columns_(columns),
        rows_(rows),
        parameters_(columns * rows, 2),
        areas_(columns * rows),
        rest_(NodeVectors::Zero(columns * rows, 3)) {
    const double h = 1 / static_cast<double>(columns - 1);
    for (Index j = 0; j < rows; ++j)
      for (Index i = 0; i < columns; ++i) {
        const bool side_1 = i == 0 || i == columns - 1, side_2 = j == 0 || j == rows - 1;
        parameters_.row(j * columns + i) << h * static_cast<double>(i), h * static_cast<double>(j);
        areas_[j * columns + i] = h * h * (side_1 ? 0.5 : 1.0) * (side_2 ? 0.5 : 1.0);
      }
    rest_.leftCols(2) = parameters_;
    initial_ = rest_;
    add_faces();
  }

  /// (N × 3) what initial() gives from now on.
  void set_initial(const NodeVectors& initial) { initial_ = initial; }

  /// Length after which a1 comes round again, from now on.
  void set_period(double period) { period_ = period; }

  [[nodiscard]] Vec2 period() const override { return {period_, 0}; }
  [[nodiscard]] Index nodes() const override { return columns_ * rows_; }
  [[nodiscard]] const Eigen::MatrixX2d& parameters() const override { return parameters_; }
  [[nodiscard]] const NodeValues& areas() const override { return areas_; }
  [[nodiscard]] const NodeVectors& rest() const override { return rest_; }
  [[nodiscard]] const NodeVectors& initial() const override { return initial_; }
  [[nodiscard]] const Faces& faces() const override { return faces_; }
  [[nodiscard]] const SampleSet& samples(SampleRole /*role*/) const override { return samples_; }
  [[nodiscard]] std::vector<std::string> boundary_names() const override {
    return {"left", "right"};
  }
  [[nodiscard]] std::vector<std::string> corner_names() const override { return {"first"}; }
  [[nodiscard]] std::vector<Index> boundary(const std::string& name) const override {
    std::vector<Index> nodes;
    if (name != "left" && name != "right") return nodes;
    for (Index j = 0; j < rows_; ++j)
      nodes.push_back(j * columns_ + (name == "left" ? 0 : columns_ - 1));
    return nodes;
  }
  [[nodiscard]] std::vector<Index> corner(const std::string& name) const override {
    return name == "first" ? std::vector<Index>{0} : std::vector<Index>{};
  }

 private:
  void add_faces() {
    for (Index j = 0; j + 1 < rows_; ++j)
      for (Index i = 0; i + 1 < columns_; ++i) {
        const Index a = j * columns_ + i;
        for (const Index node : {a, a + 1, a + columns_ + 1, a + columns_})
          faces_.nodes.push_back(static_cast<std::int32_t>(node));
        faces_.begin.push_back(static_cast<std::int32_t>(faces_.nodes.size()));
      }
  }

  Index columns_, rows_;
  double period_ = 0;
  Eigen::MatrixX2d parameters_;
  NodeValues areas_;
  NodeVectors rest_, initial_;
  Faces faces_;
  SampleSet samples_;
};

/// Selects nodes by their numbers.
inline NodeSelection nodes_numbered(std::vector<std::int64_t> numbers) {
  NodeSelector selector;
  selector.form = NodeSelector::Form::node;
  selector.numbers = std::move(numbers);
  return {{selector}};
}

}  // namespace deform::test
