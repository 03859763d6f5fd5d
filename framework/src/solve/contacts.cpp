#include "solve/contacts.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <span>
#include <utility>

#include <fmt/format.h>

#include "deform/parallel.h"

#include "not_finite.h"
#include "plugin/guard.h"

namespace deform {
namespace {

/// Out of one body a node may come into another one; in a corner of two it takes a few turns, and
/// so it does where a node that is tied moves others.
constexpr int kMostRounds = 8;
/// A way this short, relative to coordinates, is rounding.
constexpr double kNoWay = 1e-12;
/// What begins behind a tangent plane by less than this part of its way begins on it.
constexpr double kOnPlane = 1e-9;
/// Cosine of the angle between normals of the same side of a body: less than that, and a node has
/// come in on another side than the nearest.
constexpr double kSameSide = 0.5;
/// What ends farther outside of a body than this part of its way does not slide along it.
constexpr double kSlides = 1e-3;

/// Whether a node follows others.
bool is_tied(const Mobility& mobility, Index node) {
  for (int c = 0; c < 3; ++c)
    for (const Tie::Part& part : mobility.map().row({node, c}))
      if (part.of.node != node) return true;
  return false;
}

}  // namespace

Contacts::Contacts(std::vector<Body> bodies, const ReductionMap& map)
    : bodies_(std::move(bodies)), mobility_(map) {
  for (const Body& body : bodies_)
    is_convex_.push_back(guarded(body.collider.origin, "saying whether it is convex",
                                 [&] { return body.collider.object->is_convex(); }));
}

void Contacts::measure(const Body& body, double time, const NodeVectors& points,
                       NodeValues& distance, NodeVectors& normal) const {
  distance.resize(points.rows());
  normal.resize(points.rows(), 3);
  parallel_blocks(points.rows(), kBlock, [&](Index first, Index size) {
    guarded(body.collider.origin, "measuring distances", [&] {
      body.collider.object->measure(time, rows_from(points, first),
                                    {distance.data() + first, static_cast<std::size_t>(size)},
                                    rows_from(normal, first));
    });
  });
  require_finite(distance, "a distance", body.collider.origin, body.collider.name);
  require_finite(normal, "a normal", body.collider.origin, body.collider.name);
}

bool Contacts::may_cross(const Body& body, Index node, const Vec3& from, const Vec3& to, double gap,
                         const Vec3& normal) const {
  const double square = (to - from).squaredNorm();
  if ((gap > 0 && gap * gap >= square) || mobility_.is_held(node)) return false;
  if (!(square > kNoWay * kNoWay * to.squaredNorm())) return false;
  // A convex body lies behind its tangent plane: a way that begins before it does not enter but
  // where it ends.
  const bool is_convex = is_convex_[static_cast<std::size_t>(&body - bodies_.data())];
  return !is_convex || normal.dot(from - to) + gap < -kOnPlane * std::sqrt(square);
}

std::vector<EntryPlane> Contacts::crossings(const Body& body, double time, const NodeVectors& from,
                                            const NodeVectors& to, const NodeValues& distance,
                                            const NodeVectors& normal) const {
  std::vector<Index> nodes;
  for (Index a = 0; a < to.rows(); ++a)
    if (may_cross(body, a, from.row(a).transpose(), to.row(a).transpose(),
                  distance[a] - body.thickness, normal.row(a).transpose()))
      nodes.push_back(a);
  if (nodes.empty()) return {};
  const PathBody seen{[&](const NodeVectors& points, NodeValues& gap, NodeVectors& n) {
                        measure(body, time, points, gap, n);
                        gap.array() -= body.thickness;
                      },
                      is_convex_[static_cast<std::size_t>(&body - bodies_.data())]};
  std::vector<EntryPlane> entries =
      first_entries(seen, from(nodes, Eigen::all), to(nodes, Eigen::all));
  for (EntryPlane& entry : entries) entry.path = nodes[static_cast<std::size_t>(entry.path)];
  // What begins or ends on the side where it came in may have slid along a round body: where it is
  // inside, it is put at the nearest point.
  std::erase_if(entries, [&](const EntryPlane& entry) {
    const Index a = entry.path;
    const double slides = kSlides * (to.row(a) - from.row(a)).norm();
    const bool is_on_it =
        distance[a] - body.thickness <= slides || entry.gap(from.row(a).transpose()) <= slides;
    return is_on_it && entry.normal.dot(Vec3(normal.row(a).transpose())) >= kSameSide;
  });
  return entries;
}

template <class Visit>
void Contacts::visit_near(const Body& body, double time, const NodeVectors& from,
                          const NodeVectors& r, double within, const Visit& visit) const {
  NodeValues distance;
  NodeVectors normal;
  measure(body, time, r, distance, normal);
  const std::vector<EntryPlane> entries = crossings(body, time, from, r, distance, normal);
  auto entry = entries.begin();
  for (Index a = 0; a < r.rows(); ++a) {
    double gap = distance[a] - body.thickness;
    Vec3 n = normal.row(a).transpose();
    const bool crossed = entry != entries.end() && entry->path == a;
    if (crossed) {
      n = entry->normal;
      gap = (entry++)->gap(r.row(a).transpose());
    }
    const double mobility = mobility_.along(a, n);
    if (gap < within * std::max(1.0, mobility) && mobility_.is_movable(a, n))
      visit(a, gap, n, mobility, crossed);
  }
}

std::vector<Index> Contacts::resolve(const NodeVectors& before, double step, State& after) {
  std::vector<Index> all;
  for (int round = 0; round < kMostRounds; ++round) {
    bool any = false;
    for (std::size_t body = 0; body < bodies_.size(); ++body) {
      const std::vector<Index> touched = resolve(body, before, step, after);
      any = any || !touched.empty();
      all.insert(all.end(), touched.begin(), touched.end());
    }
    if (!any || (bodies_.size() == 1 && !mobility_.has_ties())) break;
  }
  std::ranges::sort(all);
  all.erase(std::unique(all.begin(), all.end()), all.end());
  return all;
}

std::vector<Index> Contacts::resolve(std::size_t body, const NodeVectors& before, double step,
                                     State& after) {
  std::vector<Index> touched;
  std::vector<ContactImpulse> impulses;
  std::vector<std::pair<Index, Vec3>> moves;  // per node, of the unknowns that it follows
  visit_near(bodies_[body], after.time, before, after.r, 0,
             [&](Index a, double gap, const Vec3& n, double /*mobility*/, bool /*crossed*/) {
               Vec3 moved = (after.r.row(a) - before.row(a)).transpose();
               Grip grip{
                   .normal = n, .friction = bodies_[body].friction, .least = moved.dot(n) - gap};
               moves.emplace_back(a, settle_motion(mobility_, a, {&grip, 1}, moved));
               impulses.push_back({.node = a, .body = body, .normal = n});
               touched.push_back(a);
             });
  // What is tied to nodes that are pushed out may come out with them: its turn is the next.
  const auto is_other = [&](Index node) { return is_tied(mobility_, node); };
  if (mobility_.has_ties() && !std::ranges::all_of(touched, is_other)) {
    std::erase_if(moves, [&](const auto& move) { return is_other(move.first); });
    std::erase_if(impulses, [&](const ContactImpulse& i) { return is_other(i.node); });
  }
  for (const auto& [node, move] : moves) mobility_.add(node, move, after.r);
  if (!touched.empty() && mobility_.has_ties()) mobility_.map().complete_positions(after.r);
  settle(step, impulses, after);
  return touched;
}

void Contacts::find(double time, const NodeVectors& from, const NodeVectors& r, double within,
                    std::vector<NodeContact>& found) const {
  found.clear();
  for (std::size_t b = 0; b < bodies_.size(); ++b)
    visit_near(bodies_[b], time, from, r, within,
               [&](Index a, double gap, const Vec3& n, double mobility, bool crossed) {
                 found.push_back({a, b, gap, n, bodies_[b].friction, mobility, crossed});
               });
}

std::vector<double> Contacts::speeds(double step, const std::vector<ContactImpulse>& impulses,
                                     const State& state) const {
  std::vector<double> speeds(impulses.size());
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    std::vector<std::size_t> of_body;
    for (std::size_t i = 0; i < impulses.size(); ++i)
      if (impulses[i].body == b) of_body.push_back(i);
    if (of_body.empty()) continue;
    NodeVectors points(static_cast<Index>(of_body.size()), 3), normal;
    for (std::size_t k = 0; k < of_body.size(); ++k)
      points.row(static_cast<Index>(k)) = state.r.row(impulses[of_body[k]].node);
    NodeValues now, earlier;
    measure(bodies_[b], state.time, points, now, normal);
    measure(bodies_[b], state.time - step, points, earlier, normal);
    for (std::size_t k = 0; k < of_body.size(); ++k)
      speeds[of_body[k]] = (earlier[static_cast<Index>(k)] - now[static_cast<Index>(k)]) / step;
  }
  return speeds;
}

void Contacts::settle(double step, const std::vector<ContactImpulse>& impulses,
                      State& state) const {
  if (impulses.empty()) return;
  const std::vector<double> speed = speeds(step, impulses, state);
  std::vector<std::size_t> by_node(impulses.size());
  std::iota(by_node.begin(), by_node.end(), std::size_t{0});
  const auto node_of = [&](std::size_t i) { return impulses[i].node; };
  std::ranges::stable_sort(by_node, {}, node_of);
  // Nodes that are tied to others come after these: most have what they need then.
  if (mobility_.has_ties())
    std::stable_partition(by_node.begin(), by_node.end(),
                          [&](std::size_t i) { return !is_tied(mobility_, node_of(i)); });
  std::vector<Grip> grips;
  for (std::size_t k = 0; k < by_node.size();) {
    const Index node = node_of(by_node[k]);
    grips.clear();
    for (; k < by_node.size() && node_of(by_node[k]) == node; ++k) {
      const ContactImpulse& i = impulses[by_node[k]];
      grips.push_back({i.normal, bodies_[i.body].friction, speed[by_node[k]], i.push, i.rub});
    }
    if (mobility_.has_ties() && is_tied(mobility_, node)) mobility_.map().complete_changes(state.v);
    Vec3 v = state.v.row(node).transpose();
    mobility_.add(node, settle_motion(mobility_, node, grips, v), state.v);
  }
  if (mobility_.has_ties()) mobility_.map().complete_changes(state.v);
}

NodeValues Contacts::clearance(double time, const NodeVectors& points) const {
  NodeValues least = NodeValues::Constant(points.rows(), std::numeric_limits<double>::infinity());
  NodeValues distance;
  NodeVectors normal;
  for (const Body& body : bodies_) {
    measure(body, time, points, distance, normal);
    least = least.cwiseMin(distance);
  }
  return least;
}

void Contacts::require_outside(const NodeVectors& r, double slack) const {
  NodeValues distance;
  NodeVectors normal;
  std::vector<Problem> problems;
  for (const Body& body : bodies_) {
    try {
      measure(body, 0, r, distance, normal);
    } catch (const NotFinite& e) {
      problems.push_back({body.pointer, fmt::format("at {}: {} at first: no number holds squares "
                                                    "of such sizes",
                                                    body.pointer, e.what())});
      continue;
    }
    Index worst = -1;
    for (Index a = 0; a < r.rows(); ++a)
      if ((worst < 0 || distance[a] < distance[worst]) &&
          mobility_.is_movable(a, normal.row(a).transpose()))
        worst = a;
    if (worst < 0 || body.thickness - distance[worst] <= slack) continue;
    problems.push_back(
        {body.pointer,
         fmt::format("at {}: node {} begins {:.3g} m inside of this collider (thickness included), "
                     "expected all nodes outside",
                     body.pointer, worst, body.thickness - distance[worst])});
  }
  if (!problems.empty()) throw InputError(std::move(problems));
}

}  // namespace deform
