#include "compare/hausdorff.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include <boost/geometry.hpp>
#include <boost/geometry/geometries/box.hpp>
#include <boost/geometry/geometries/point.hpp>
#include <boost/geometry/index/rtree.hpp>

namespace deform {
namespace {

namespace bg = boost::geometry;
using Point = bg::model::point<double, 3, bg::cs::cartesian>;
using Box = bg::model::box<Point>;

double squared_distance_to_segment(const Vec3& p, const Vec3& a, const Vec3& b) {
  const Vec3 ab = b - a;
  const double length = ab.squaredNorm();
  const double t = length > 0 ? std::clamp((p - a).dot(ab) / length, 0.0, 1.0) : 0.0;
  return (p - a - t * ab).squaredNorm();
}

/// The triangles of a surface, by place.
class TriangleTree {
 public:
  TriangleTree(const NodeVectors& r, const std::vector<Triangle>& faces) : r_(r), faces_(faces) {
    std::vector<std::pair<Box, std::size_t>> boxes;
    boxes.reserve(faces.size());
    for (std::size_t f = 0; f < faces.size(); ++f) {
      const Vec3 a = corner(f, 0), b = corner(f, 1), c = corner(f, 2);
      boxes.emplace_back(Box(point(a.cwiseMin(b).cwiseMin(c)), point(a.cwiseMax(b).cwiseMax(c))),
                         f);
    }
    tree_ = Tree(boxes.begin(), boxes.end());
  }

  /// Squared distance of p to the nearest triangle, or, once one is found that is no farther than
  /// `enough`, the distance to that one.
  [[nodiscard]] double squared_distance_to(const Vec3& p, double enough) const {
    double best = std::numeric_limits<double>::infinity();
    const Point at = point(p);
    const auto all = static_cast<unsigned>(faces_.size());
    for (auto it = tree_.qbegin(bg::index::nearest(at, all)); it != tree_.qend(); ++it) {
      if (bg::comparable_distance(at, it->first) >= best) break;
      const std::size_t f = it->second;
      best = std::min(best, squared_distance(p, corner(f, 0), corner(f, 1), corner(f, 2)));
      if (best <= enough) break;
    }
    return best;
  }

 private:
  using Tree = bg::index::rtree<std::pair<Box, std::size_t>, bg::index::quadratic<16>>;
  static Point point(const Vec3& v) { return {v.x(), v.y(), v.z()}; }
  [[nodiscard]] Vec3 corner(std::size_t f, std::size_t k) const {
    return r_.row(faces_[f][k]).transpose();
  }

  const NodeVectors& r_;
  const std::vector<Triangle>& faces_;
  Tree tree_;
};

/// The greatest squared distance from a node of a to b, if it is more than `known`; else that.
double greatest_squared_distance(const NodeVectors& a, const NodeValues& near_a,
                                 const TriangleTree& b, double known) {
  std::vector<Index> order(static_cast<std::size_t>(a.rows()));
  std::iota(order.begin(), order.end(), Index{0});
  std::ranges::sort(order, [&](Index i, Index j) { return near_a[i] > near_a[j]; });
  for (const Index i : order) {
    if (near_a[i] * near_a[i] <= known) break;  // nor do those that follow reach farther
    known = std::max(known, b.squared_distance_to(a.row(i).transpose(), known));
  }
  return known;
}

}  // namespace

double squared_distance(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 normal = (b - a).cross(c - a);
  const auto inside = [&](const Vec3& from, const Vec3& to) {
    return normal.dot((to - from).cross(p - from)) >= 0;
  };
  const double area = normal.squaredNorm();
  if (area > 0 && inside(a, b) && inside(b, c) && inside(c, a)) {
    const double height = normal.dot(p - a);
    return height * height / area;
  }
  return std::min({squared_distance_to_segment(p, a, b), squared_distance_to_segment(p, b, c),
                   squared_distance_to_segment(p, c, a)});
}

double hausdorff_distance(const NodeVectors& a, const std::vector<Triangle>& faces_a,
                          const NodeValues& near_a, const NodeVectors& b,
                          const std::vector<Triangle>& faces_b, const NodeValues& near_b) {
  if (near_a.maxCoeff() == 0 && near_b.maxCoeff() == 0) return 0;
  const double there = greatest_squared_distance(a, near_a, TriangleTree(b, faces_b), 0);
  const double back = greatest_squared_distance(b, near_b, TriangleTree(a, faces_a), there);
  return std::sqrt(back);
}

}  // namespace deform
