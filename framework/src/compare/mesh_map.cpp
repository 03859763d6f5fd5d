#include "compare/mesh_map.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include <boost/geometry.hpp>
#include <boost/geometry/geometries/box.hpp>
#include <boost/geometry/geometries/point.hpp>
#include <boost/geometry/index/rtree.hpp>
#include <fmt/format.h>

#include "deform/error.h"

#include "compare/triangles.h"

namespace deform {
namespace {

namespace bg = boost::geometry;
using Point = bg::model::point<double, 2, bg::cs::cartesian>;
using Box = bg::model::box<Point>;

/// Of the mesh's extent: what rounding may put a place outside.
constexpr double kSlack = 1e-9;

/// The faces' triangles in the parameter plane, by place.
class ParameterPlane {
 public:
  explicit ParameterPlane(const TrajectoryMesh& mesh)
      : parameters_(mesh.parameters), triangles_(triangles_of(mesh.faces)) {
    const Vec2 extent = parameters_.colwise().maxCoeff() - parameters_.colwise().minCoeff();
    slack_ = kSlack * extent.maxCoeff();
    std::vector<std::pair<Box, std::size_t>> boxes;
    for (std::size_t t = 0; t < triangles_.size(); ++t) {
      if (!joins_sides(t, extent)) boxes.emplace_back(box(t), t);
    }
    tree_ = {boxes.begin(), boxes.end()};
  }

  struct Hit {
    Triangle nodes;
    std::array<double, 3> weights;
  };

  /// The triangle that the place lies in the most, and its barycentric coordinates there.
  [[nodiscard]] std::optional<Hit> find(const Vec2& place) const {
    std::optional<Hit> best;
    double most = -std::numeric_limits<double>::infinity();
    for (auto it = tree_.qbegin(bg::index::intersects(around(place))); it != tree_.qend(); ++it) {
      const Hit hit{triangles_[it->second], barycentric(it->second, place)};
      const double least = *std::ranges::min_element(hit.weights);
      if (least > most) most = least, best = hit;
      if (least >= 0) break;
    }
    return most >= -1e-6 ? best : std::nullopt;
  }

 private:
  [[nodiscard]] Vec2 corner(std::size_t t, std::size_t k) const {
    return parameters_.row(triangles_[t][k]).transpose();
  }
  /// A triangle between two joined sides of a periodic surface goes the long way round in the
  /// plane.
  [[nodiscard]] bool joins_sides(std::size_t t, const Vec2& extent) const {
    const Vec2 a = corner(t, 0), b = corner(t, 1), c = corner(t, 2);
    const Vec2 span = a.cwiseMax(b).cwiseMax(c) - a.cwiseMin(b).cwiseMin(c);
    return (span.array() > 0.55 * extent.array()).any();
  }
  [[nodiscard]] Box box(std::size_t t) const {
    const Vec2 a = corner(t, 0), b = corner(t, 1), c = corner(t, 2);
    const Vec2 low = a.cwiseMin(b).cwiseMin(c), high = a.cwiseMax(b).cwiseMax(c);
    return {{low.x(), low.y()}, {high.x(), high.y()}};
  }
  [[nodiscard]] Box around(const Vec2& p) const {
    return {{p.x() - slack_, p.y() - slack_}, {p.x() + slack_, p.y() + slack_}};
  }
  [[nodiscard]] std::array<double, 3> barycentric(std::size_t t, const Vec2& p) const {
    const auto cross = [](const Vec2& u, const Vec2& v) { return u.x() * v.y() - u.y() * v.x(); };
    const Vec2 a = corner(t, 0), b = corner(t, 1), c = corner(t, 2);
    const double area = cross(b - a, c - a);
    return {cross(b - p, c - p) / area, cross(c - p, a - p) / area, cross(a - p, b - p) / area};
  }

  const Eigen::MatrixX2d& parameters_;
  std::vector<Triangle> triangles_;
  double slack_ = 0;
  bg::index::rtree<std::pair<Box, std::size_t>, bg::index::rstar<16>> tree_;
};

}  // namespace

bool has_chart(const TrajectoryMesh& mesh) {
  return mesh.parameters.rows() < 2 ||
         mesh.parameters.colwise().maxCoeff() != mesh.parameters.colwise().minCoeff();
}

MeshMap::MeshMap(const TrajectoryMesh& mesh, const Eigen::MatrixX2d& places) {
  identity_ = mesh.parameters.rows() == places.rows() && mesh.parameters == places;
  if (identity_) return;
  if (!has_chart(mesh))
    throw InputError(
        "the surfaces have different nodes and no parameters, by which one could be found on the "
        "other, so the two cannot be compared");
  const ParameterPlane plane(mesh);
  rows_.reserve(static_cast<std::size_t>(places.rows()));
  for (Index i = 0; i < places.rows(); ++i) {
    const auto hit = plane.find(places.row(i).transpose());
    if (!hit) {
      throw InputError(
          fmt::format("node {} at (a1, a2) = ({:g}, {:g}) m lies outside the other "
                      "surface, so the two cannot be compared",
                      i, places(i, 0), places(i, 1)));
    }
    Row row{hit->nodes, hit->weights};
    // Rounding of the parameters must not make a node of the mesh a mixture of its neighbours.
    for (double& w : row.weights) {
      if (std::abs(w) < 1e-9) w = 0;
      if (std::abs(w - 1) < 1e-9) w = 1;
    }
    rows_.push_back(row);
  }
}

NodeVectors MeshMap::apply(const NodeVectors& values) const {
  if (identity_) return values;
  NodeVectors at(static_cast<Index>(rows_.size()), 3);
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    Vec3 sum = Vec3::Zero();
    for (std::size_t k = 0; k < 3; ++k) {
      const double w = rows_[i].weights[k];
      if (w != 0) sum += w * values.row(rows_[i].nodes[k]).transpose();
    }
    at.row(static_cast<Index>(i)) = sum.transpose();
  }
  return at;
}

std::vector<float> MeshMap::apply_nearest(const std::vector<float>& values) const {
  if (identity_) return values;
  std::vector<float> at;
  at.reserve(rows_.size());
  for (const Row& row : rows_) {
    const auto largest = std::ranges::max_element(row.weights) - row.weights.begin();
    at.push_back(values[static_cast<std::size_t>(row.nodes[static_cast<std::size_t>(largest)])]);
  }
  return at;
}

}  // namespace deform
