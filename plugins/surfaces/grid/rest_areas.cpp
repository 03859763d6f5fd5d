#include "rest_areas.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace grid {
namespace {

using deform::NodeValues;
using deform::NodeVectors;
using deform::Vec3;

/// Nodes of an interpolation along a line, at most, and points of Gauss's rule within a cell.
constexpr Index kNodes = 6;
constexpr std::size_t kPoints = 2;
const std::array<double, kPoints> kGauss{0.5 - 0.5 / std::sqrt(3.0), 0.5 + 0.5 / std::sqrt(3.0)};

/// Interpolations by 2, 4, 6 nodes of a line. Where the surface is smooth and resolved, each next
/// one changes a cell's area by far less than the one before. Where it does not (creases, measured
/// shapes), its facets are what is known of it.
constexpr std::array<Index, 3> kOrders{2, 4, kNodes};
constexpr double kSlow = 0.25;
/// A change by less than this part is none.
constexpr double kNoChange = 1e-6;

/// The place in kOrders of the best of a measure's values by these interpolations.
std::size_t best(const std::array<double, 3>& by_order) {
  const double last = std::abs(by_order[2] - by_order[1]);
  const bool is_smooth =
      last <= kNoChange * by_order[2] || last <= kSlow * std::abs(by_order[1] - by_order[0]);
  return is_smooth ? 2 : 0;
}

/// Means that differ from 1 by less than so many roundings of positions, relative to the distance
/// of nodes, are 1.
constexpr double kRoundings = 64;

/// Lagrange's interpolation of values at nodes `first`, first + 1, … of a line at the points of a
/// cell: coefficients of the value and of its derivative by the parameter in cells.
struct Interpolation {
  Index first = 0, size = 0;
  std::array<std::array<double, kNodes>, kPoints> value{}, derivative{};
};

/// Coefficients of the polynomial through 0, 1, …, size − 1 at x.
void set_lagrange(Index size, double x, std::array<double, kNodes>& value,
                  std::array<double, kNodes>& derivative) {
  for (Index k = 0; k < size; ++k) {
    double product = 1, slope = 0;
    for (Index l = 0; l < size; ++l) {
      if (l == k) continue;
      const double width = static_cast<double>(k - l),
                   factor = (x - static_cast<double>(l)) / width;
      slope = slope * factor + product / width;
      product *= factor;
    }
    value[static_cast<std::size_t>(k)] = product;
    derivative[static_cast<std::size_t>(k)] = slope;
  }
}

/// That of each cell of a line: by so many nodes, as many on either side of it, at open ends by
/// those that are nearest.
std::vector<Interpolation> interpolations(Index n, bool periodic, Index nodes) {
  std::vector<Interpolation> result;
  const Index cells = periodic ? n : n - 1;
  for (Index cell = 0; cell < cells; ++cell) {
    Interpolation at{.size = std::min(n, nodes)};
    at.first = cell - (at.size / 2 - 1);
    if (!periodic) at.first = std::clamp<Index>(at.first, 0, n - at.size);
    for (std::size_t q = 0; q < kPoints; ++q)
      set_lagrange(at.size, static_cast<double>(cell - at.first) + kGauss[q], at.value[q],
                   at.derivative[q]);
    result.push_back(at);
  }
  return result;
}

/// Σ c_k v_k over the nodes of an interpolation.
template <class Values>
Vec3 sum(const Interpolation& at, const std::array<double, kNodes>& c, const Values& v) {
  Vec3 result = Vec3::Zero();
  for (Index k = 0; k < at.size; ++k) result += c[static_cast<std::size_t>(k)] * v(k);
  return result;
}

/// What a mean of |dr/da| or |r_1 × r_2| may differ by from 1 and is 1.
double rounding(const NodeVectors& r, double h) {
  return kRoundings * std::numeric_limits<double>::epsilon() * r.cwiseAbs().maxCoeff() / h;
}

/// Weighted means at nodes of what is given at points of cells.
class Means {
 public:
  explicit Means(Index nodes) : sum_(NodeValues::Zero(nodes)), weight_(sum_) {}
  void add(Index node, double weight, double value) {
    sum_[node] += weight * value;
    weight_[node] += weight;
  }
  /// 1 where that is the mean but for rounding.
  [[nodiscard]] double at(Index node, double tolerance) const {
    const double mean = sum_[node] / weight_[node];
    return std::abs(mean - 1) <= tolerance ? 1 : mean;
  }

 private:
  NodeValues sum_, weight_;
};

/// The share of a point of a cell that its node at `side` 0 or 1 has.
double share(std::size_t side, std::size_t q) { return side == 0 ? 1 - kGauss[q] : kGauss[q]; }

/// |r_1 × r_2| at the points (p, q) of a cell.
using ElementsOfCell = std::array<std::array<double, kPoints>, kPoints>;

double total(const ElementsOfCell& e) { return e[0][0] + e[0][1] + e[1][0] + e[1][1]; }

/// r_1 and r_2 at the points of cells.
class AreaElements {
 public:
  AreaElements(const Lattice& lattice, const NodeVectors& r) : lattice_(lattice), r_(r) {
    for (std::size_t k = 0; k < kOrders.size(); ++k) {
      along_1_[k] = interpolations(lattice.n[0], lattice.periodic[0], kOrders[k]);
      along_2_[k] = interpolations(lattice.n[1], lattice.periodic[1], kOrders[k]);
    }
  }

  /// Of cell (i, j).
  [[nodiscard]] ElementsOfCell of_cell(Index i, Index j) const {
    std::array<ElementsOfCell, kOrders.size()> by_order;
    std::array<double, kOrders.size()> areas{};
    for (std::size_t k = 0; k < kOrders.size(); ++k) {
      by_order[k] = of_cell(along_1_[k][static_cast<std::size_t>(i)],
                            along_2_[k][static_cast<std::size_t>(j)]);
      areas[k] = total(by_order[k]);
    }
    return by_order[best(areas)];
  }

 private:
  [[nodiscard]] ElementsOfCell of_cell(const Interpolation& at_1, const Interpolation& at_2) const {
    const std::array<Index, 2>& n = lattice_.n;
    ElementsOfCell result{};
    for (std::size_t p = 0; p < kPoints; ++p) {
      std::array<Vec3, kNodes> value, derivative;  // along a1, on the lines of at_2
      for (Index l = 0; l < at_2.size; ++l) {
        const auto position = [&, line = (at_2.first + l + n[1]) % n[1]](Index k) {
          return Vec3(r_.row(lattice_.node((at_1.first + k + n[0]) % n[0], line)));
        };
        value[static_cast<std::size_t>(l)] = sum(at_1, at_1.value[p], position);
        derivative[static_cast<std::size_t>(l)] =
            sum(at_1, at_1.derivative[p], position) / lattice_.h[0];
      }
      const auto on = [](const std::array<Vec3, kNodes>& lines) {
        return [&lines](Index l) { return lines[static_cast<std::size_t>(l)]; };
      };
      for (std::size_t q = 0; q < kPoints; ++q) {
        const Vec3 r_1 = sum(at_2, at_2.value[q], on(derivative)),
                   r_2 = sum(at_2, at_2.derivative[q], on(value)) / lattice_.h[1];
        result[p][q] = r_1.cross(r_2).norm();
      }
    }
    return result;
  }

  const Lattice& lattice_;
  const NodeVectors& r_;
  std::array<std::vector<Interpolation>, kOrders.size()> along_1_, along_2_;
};

}  // namespace

NodeValues rest_areas(const Lattice& lattice, const NodeValues& areas, const NodeVectors& r) {
  const AreaElements elements(lattice, r);
  const auto& [n, h, periodic] = lattice;
  Means means(lattice.nodes());
  for (Index j = 0; j < lattice.cells(1); ++j)
    for (Index i = 0; i < lattice.cells(0); ++i) {
      const auto element = elements.of_cell(i, j);
      for (const std::size_t side_2 : {0U, 1U})
        for (const std::size_t side_1 : {0U, 1U}) {
          const Index node = lattice.node((i + static_cast<Index>(side_1)) % n[0],
                                          (j + static_cast<Index>(side_2)) % n[1]);
          for (std::size_t q = 0; q < kPoints; ++q)
            for (std::size_t p = 0; p < kPoints; ++p)
              means.add(node, share(side_1, p) * share(side_2, q), element[p][q]);
        }
    }
  const double tolerance = rounding(r, std::min(h[0], h[1]));
  NodeValues result = areas;
  for (Index a = 0; a < lattice.nodes(); ++a) result[a] *= means.at(a, tolerance);
  return result;
}

std::vector<double> rest_lengths(const std::vector<Index>& side, double h, bool periodic,
                                 const std::vector<double>& lengths, const NodeVectors& r) {
  const auto n = static_cast<Index>(side.size());
  std::array<std::vector<Interpolation>, kOrders.size()> cells;
  for (std::size_t k = 0; k < kOrders.size(); ++k)
    cells[k] = interpolations(n, periodic, kOrders[k]);
  Means means(n);
  for (Index cell = 0; cell < static_cast<Index>(cells[0].size()); ++cell) {
    std::array<std::array<double, kPoints>, kOrders.size()> speeds{};
    std::array<double, kOrders.size()> lengths_by_order{};
    for (std::size_t k = 0; k < kOrders.size(); ++k) {
      const Interpolation& at = cells[k][static_cast<std::size_t>(cell)];
      const auto position = [&](Index l) {
        return Vec3(r.row(side[static_cast<std::size_t>((at.first + l + n) % n)]));
      };
      for (std::size_t p = 0; p < kPoints; ++p)
        speeds[k][p] = sum(at, at.derivative[p], position).norm() / h;
      lengths_by_order[k] = speeds[k][0] + speeds[k][1];
    }
    const std::array<double, kPoints>& speed = speeds[best(lengths_by_order)];
    for (std::size_t p = 0; p < kPoints; ++p) {
      means.add(cell, share(0, p), speed[p]);
      means.add((cell + 1) % n, share(1, p), speed[p]);
    }
  }
  std::vector<double> result = lengths;
  for (Index k = 0; k < n; ++k) result[static_cast<std::size_t>(k)] *= means.at(k, rounding(r, h));
  return result;
}

}  // namespace grid
