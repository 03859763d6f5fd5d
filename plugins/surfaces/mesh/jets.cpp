#include "jets.h"

#include <algorithm>
#include <cmath>

#include <Eigen/SVD>

#include <deform/error.h>
#include <deform/geometry/best_fit_plane.h>
#include <deform/geometry/characteristic_length.h>

namespace mesh {
namespace {

using namespace deform;

/// Farther from a plane than this part of its size, a surface does not lie in it.
constexpr double kFlat = 1e-9;
/// A fit's least singular value beside its largest, from which on it counts as determined well, and
/// from which on at all.
constexpr double kGood = 0.1, kLeast = 1e-3;
constexpr int kMostRings = 4;

/// An axis in the plane normal to n, the same for the same n: towards the axis of space that is the
/// farthest from n.
Axes axes_across(const Vec3& n) {
  Index farthest = 0;
  n.cwiseAbs().minCoeff(&farthest);
  Axes axes;
  axes.col(0) = (Vec3::Unit(farthest) - n[farthest] * n).normalized();
  axes.col(1) = n.cross(Vec3(axes.col(0)));
  return axes;
}

/// Nodes around each node, by edges.
class Neighbours {
 public:
  explicit Neighbours(const Triangles& t) : of_(static_cast<std::size_t>(t.nodes())) {
    for (const Triangle& corners : t.all)
      for (std::size_t k = 0; k < 3; ++k)
        for (const std::size_t j : {(k + 1) % 3, (k + 2) % 3})
          of_[static_cast<std::size_t>(corners[k])].push_back(corners[j]);
    for (auto& nodes : of_) {
      std::ranges::sort(nodes);
      nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
    }
  }

  /// Adds a ring to the nodes within some rings of one, ascending, itself among them.
  void grow(std::vector<std::int32_t>& nodes) const {
    const std::vector<std::int32_t> inner = nodes;
    for (const std::int32_t a : inner) {
      const auto& more = of_[static_cast<std::size_t>(a)];
      nodes.insert(nodes.end(), more.begin(), more.end());
    }
    std::ranges::sort(nodes);
    nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
  }

 private:
  std::vector<std::vector<std::int32_t>> of_;
};

/// Rows of D_1, D_2, D_11, D_12, D_22 over the neighbours of a node; how well they are determined.
struct Fit {
  Eigen::Matrix<double, 5, Eigen::Dynamic> rows;
  double condition = 0;
};

/// Minimises Σ w_b² |r_1 u_b + r_2 v_b + ½ r_11 u_b² + r_12 u_b v_b + ½ r_22 v_b² − (r_b − r_a)|²
/// with w = 1/distance, lengths being measured by the mean distance h.
Fit fit(const NodeVectors& r, std::int32_t a, const std::vector<std::int32_t>& nodes,
        const Axes& axes) {
  const auto count = static_cast<Index>(nodes.size());
  Eigen::MatrixX2d x(count, 2);
  for (Index b = 0; b < count; ++b)
    x.row(b) = (r.row(nodes[static_cast<std::size_t>(b)]) - r.row(a)) * axes;
  const Eigen::VectorXd distance = x.rowwise().norm();
  const double h = distance.mean();
  Eigen::MatrixXd A(count, 5);
  Eigen::VectorXd weight(count);
  for (Index b = 0; b < count; ++b) {
    const double u = x(b, 0) / h, v = x(b, 1) / h;
    weight[b] = h / std::max(distance[b], 1e-6 * h);
    A.row(b) << u, v, 0.5 * u * u, u * v, 0.5 * v * v;
    A.row(b) *= weight[b];
  }
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(A, Eigen::ComputeThinU | Eigen::ComputeThinV);
  Fit found;
  if (count < 5 || !(svd.singularValues()[0] > 0)) return found;
  found.condition = svd.singularValues()[4] / svd.singularValues()[0];
  if (!(found.condition >= kLeast)) return found;
  found.rows = svd.matrixV() * svd.singularValues().cwiseInverse().asDiagonal() *
               svd.matrixU().transpose() * weight.asDiagonal();
  found.rows.topRows<2>() /= h;
  found.rows.bottomRows<3>() /= h * h;
  return found;
}

/// Parameters that samples are said to have: in the chart of the whole surface, if there is one.
Vec2 parameter_of(const Vec3& r, const std::optional<Axes>& axes) {
  return axes ? Vec2(axes->transpose() * r) : Vec2(Vec2::Zero());
}

}  // namespace

std::optional<Axes> axes_of_plane(const Triangles& t) {
  const BestFitPlane plane = best_fit_plane(t.positions);
  if (!(plane.rms_distance <= kFlat * characteristic_length(t.positions))) return std::nullopt;
  const double side = plane.normal.dot(doubled_area(t.positions, t.all.front()));
  for (const Triangle& corners : t.all)  // folded over: no coordinates of the plane are its own
    if (side * plane.normal.dot(doubled_area(t.positions, corners)) < 0) return std::nullopt;
  Axes axes = plane.axes;
  if (side < 0) axes.col(1) *= -1;
  return axes;
}

NodeValues node_areas(const Triangles& t) {
  NodeValues areas = NodeValues::Zero(t.nodes());
  for (const Triangle& corners : t.all)
    for (const std::int32_t a : corners) areas[a] += doubled_area(t.positions, corners).norm() / 6;
  return areas;
}

SampleSet triangle_samples(const Triangles& t, const std::optional<Axes>& axes) {
  SampleSet::Builder set(t.nodes());
  for (const Triangle& corners : t.all) {
    const Vec3 area = doubled_area(t.positions, corners);
    const Axes chart = axes ? *axes : axes_across(area.normalized());
    // Columns: the edges from the first corner in the chart; D_i of the other two are rows of the
    // inverse, that of the first is what makes constants vanish.
    Eigen::Matrix2d edges;
    for (Index k = 0; k < 2; ++k)
      edges.col(k) =
          chart.transpose() * Vec3(t.positions.row(corners[static_cast<std::size_t>(k) + 1]) -
                                   t.positions.row(corners[0]));
    const Eigen::Matrix2d gradients = edges.inverse();
    SampleStencil sample;
    sample.weight = 0.5 * std::abs(edges.determinant());
    Vec3 centre = Vec3::Zero();
    for (std::size_t k = 0; k < 3; ++k) {
      const Eigen::RowVector2d d =
          k == 0 ? Eigen::RowVector2d(-gradients.colwise().sum())
                 : Eigen::RowVector2d(gradients.row(static_cast<Index>(k) - 1));
      sample.entries.push_back({corners[k], {1.0 / 3, d[0], d[1], 0, 0, 0}});
      centre += t.positions.row(corners[k]) / 3;
    }
    sample.parameter = parameter_of(centre, axes);
    for (const Derivative d : {Derivative::d0, Derivative::d1, Derivative::d2})
      sample.computable.set(static_cast<std::size_t>(slot(d)));
    set.add(sample);
  }
  return set.build();
}

SampleSet node_samples(const Triangles& t, const NodeValues& areas,
                       const std::optional<Axes>& axes) {
  const Neighbours neighbours(t);
  NodeVectors normals = NodeVectors::Zero(t.nodes(), 3);
  for (const Triangle& corners : t.all)
    for (const std::int32_t a : corners)
      normals.row(a) += doubled_area(t.positions, corners).transpose();
  std::vector<bool> is_inside(static_cast<std::size_t>(t.nodes()), true);
  for (const Loop& border : t.borders)
    for (const Index a : border) is_inside[static_cast<std::size_t>(a)] = false;
  SampleSet::Builder set(t.nodes());
  for (Index a = 0; a < t.nodes(); ++a) {
    const auto self = static_cast<std::int32_t>(a);
    const Vec3 normal = normals.row(a);
    if (!(normal.norm() > 0))
      throw InputError({Problem{"/path", "the triangles around vertex " + std::to_string(a) +
                                             " cancel: it has no tangent plane"}});
    const Axes chart = axes ? *axes : axes_across(normal.normalized());
    std::vector<std::int32_t> nodes{self}, others;
    Fit best;
    for (int rings = 1; rings <= kMostRings && best.condition < kGood; ++rings) {
      neighbours.grow(nodes);
      if (rings == 1 && !is_inside[static_cast<std::size_t>(a)]) continue;
      std::vector<std::int32_t> around = nodes;
      std::erase(around, self);
      Fit found = fit(t.positions, self, around, chart);
      if (found.condition > best.condition) best = std::move(found), others = std::move(around);
    }
    if (!(best.condition >= kLeast))
      throw InputError({Problem{"/path", "the neighbours of vertex " + std::to_string(a) +
                                             " do not determine second derivatives"}});
    SampleStencil sample;
    sample.weight = areas[a];
    sample.parameter = parameter_of(t.positions.row(a), axes);
    sample.computable.set();
    SampleStencil::Entry own{a, {1, 0, 0, 0, 0, 0}};
    for (std::size_t b = 0; b < others.size(); ++b) {
      SampleStencil::Entry entry{others[b], {}};
      for (std::size_t m = 0; m < 5; ++m) {
        entry.d[m + 1] = best.rows(static_cast<Index>(m), static_cast<Index>(b));
        own.d[m + 1] -= entry.d[m + 1];
      }
      sample.entries.push_back(entry);
    }
    sample.entries.insert(
        std::ranges::upper_bound(sample.entries, a, {}, &SampleStencil::Entry::node), own);
    set.add(sample);
  }
  return set.build();
}

}  // namespace mesh
