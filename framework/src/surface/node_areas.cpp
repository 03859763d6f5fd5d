/// Areas that nodes stand for: of the rest surface, and within selections.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "deform/surface/surface.h"

#include "surface/patches.h"

namespace deform {
namespace {

/// Areas within so many roundings of positions, relative to the distance of nodes, are the same.
constexpr double kRoundings = 64;

/// Calls visit(corners, area) for each triangle of each face, which is cut from its first corner.
template <class Visit>
void visit_triangles(const Faces& faces, const Visit& visit) {
  for (std::size_t f = 0; f + 1 < faces.begin.size(); ++f)
    for (auto c = static_cast<std::size_t>(faces.begin[f]) + 1;
         c + 1 < static_cast<std::size_t>(faces.begin[f + 1]); ++c)
      visit(f, std::array<Index, 3>{faces.nodes[static_cast<std::size_t>(faces.begin[f])],
                                    faces.nodes[c], faces.nodes[c + 1]});
}

/// b − a, the shortest way round joined sides.
Vec2 difference(const Vec2& a, const Vec2& b, const Vec2& period) {
  Vec2 d = b - a;
  for (const Index k : {0, 1})
    if (period[k] > 0) d[k] -= period[k] * std::round(d[k] / period[k]);
  return d;
}

}  // namespace

std::optional<ParameterRectangle> rectangle_of(const NodeSelector& selector) {
  if (selector.form == NodeSelector::Form::box)
    return ParameterRectangle{selector.lower, selector.upper};
  if (selector.form != NodeSelector::Form::centre) return std::nullopt;
  const Vec2 reach = Vec2::Constant(selector.radius);
  return ParameterRectangle{selector.centre - reach, selector.centre + reach};
}

bool is_patch(const ParameterRectangle& rectangle) {
  return (rectangle.lower.array() < rectangle.upper.array()).all();
}

bool contains(const ParameterRectangle& rectangle, const Vec2& a, const Vec2& period) {
  constexpr double kRim = 1e-9;
  const double rim = kRim * std::max(rectangle.lower.lpNorm<Eigen::Infinity>(),
                                     rectangle.upper.lpNorm<Eigen::Infinity>());
  const auto is_between = [&](Index k) {
    const double lower = rectangle.lower[k] - rim, upper = rectangle.upper[k] + rim;
    const double image =
        period[k] > 0 ? a[k] + period[k] * std::ceil((lower - a[k]) / period[k]) : a[k];
    return image >= lower && image <= upper;
  };
  return is_between(0) && is_between(1);
}

NodeValues Surface::rest_areas() const {
  const auto n = static_cast<std::size_t>(faces().size());
  const Vec2 joined = period();
  std::vector<double> of_rest(n), of_parameters(n);
  visit_triangles(faces(), [&](std::size_t f, const std::array<Index, 3>& at) {
    const auto& [a, b, c] = at;
    const Vec3 u = rest().row(b) - rest().row(a), v = rest().row(c) - rest().row(a);
    const Vec2 p = difference(parameters().row(a), parameters().row(b), joined),
               q = difference(parameters().row(a), parameters().row(c), joined);
    of_rest[f] += 0.5 * u.cross(v).norm();
    of_parameters[f] += 0.5 * std::abs(p.x() * q.y() - p.y() * q.x());
  });
  NodeValues around_rest = NodeValues::Zero(nodes()), around_parameters = around_rest;
  for (std::size_t f = 0; f < n; ++f)
    for (auto c = faces().begin[f]; c < faces().begin[f + 1]; ++c) {
      const std::int32_t node = faces().nodes[static_cast<std::size_t>(c)];
      around_rest[node] += of_rest[f];
      around_parameters[node] += of_parameters[f];
    }
  NodeValues result = areas();
  const double rounding =
      kRoundings * std::numeric_limits<double>::epsilon() * rest().cwiseAbs().maxCoeff();
  for (Index a = 0; a < nodes(); ++a) {
    if (!(around_parameters[a] > 0)) continue;  // on no face: it has no other area
    const double quotient = around_rest[a] / around_parameters[a];
    const double tolerance = rounding / std::sqrt(around_parameters[a]);
    if (std::abs(quotient - 1) > tolerance) result[a] *= quotient;
  }
  return result;
}

NodeValues Surface::areas_within(const std::vector<ParameterRectangle>& rectangles) const {
  NodeValues result = NodeValues::Zero(nodes());
  for (Index a = 0; a < nodes(); ++a)
    if (std::ranges::any_of(rectangles, [&](const ParameterRectangle& r) {
          return contains(r, parameters().row(a), period());
        }))
      result[a] = areas()[a];
  return result;
}

NodeValues select_areas(const Surface& surface, const NodeSelection& where) {
  std::vector<ParameterRectangle> patches, lines;
  if (!surface.has_chart() && std::ranges::any_of(where.selectors, [](const NodeSelector& s) {
        return rectangle_of(s).has_value();
      }))
    (void)select_nodes(surface, where);  // says why not
  NodeSelection named{.selectors = {}, .pointer = where.pointer};
  for (const NodeSelector& selector : where.selectors) {
    if (const auto rectangle = rectangle_of(selector))
      (is_patch(*rectangle) ? patches : lines).push_back(*rectangle);
    else
      named.selectors.push_back(selector);
  }
  NodeValues result = NodeValues::Zero(surface.nodes());
  if (!patches.empty()) result = surface.areas_within(patches);
  const auto take = [&](Index node) { result[node] = surface.areas()[node]; };
  for (Index a = 0; a < surface.nodes() && !lines.empty(); ++a)
    if (std::ranges::any_of(lines, [&](const ParameterRectangle& line) {
          return contains(line, surface.parameters().row(a), surface.period());
        }))
      take(a);
  if (!named.selectors.empty()) std::ranges::for_each(select_nodes(surface, named), take);
  if (!(result.maxCoeff() > 0)) (void)select_nodes(surface, where);  // says that there is none
  return result;
}

}  // namespace deform
