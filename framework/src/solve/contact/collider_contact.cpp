#include "deform/solve/collider_contact.h"

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
#include "solve/contact/contact_law.h"
#include "solve/contact/contact_paths.h"

namespace deform {
namespace {

/// Out of one body a node may come into another one; in a corner of two it takes a few turns, and
/// so it does where a node that is tied moves others.
constexpr int kMostRounds = 8;
/// A path this short, relative to coordinates, is rounding.
constexpr double kNoPath = 1e-12;
/// What begins behind a tangent plane by less than this part of its path begins on it.
constexpr double kOnPlane = 1e-9;
/// Cosine of the angle between normals of the same side of a body: less than that, and a node has
/// come in on another side than the nearest.
constexpr double kSameSide = 0.5;
/// What ends farther outside of a body than this part of its path does not slide along it.
constexpr double kSlides = 1e-3;

/// Whether a node follows others.
bool is_tied(const Mobility& mobility, Index node) {
  for (int c = 0; c < 3; ++c)
    for (const Tie::Part& part : mobility.map().row({node, c}))
      if (part.of.node != node) return true;
  return false;
}

}  // namespace

struct ColliderContact::Impl {
  Impl(std::vector<Body> of, Index nodes, const ReductionMap& map);

  std::vector<ContactImpulse> resolve(const State& before, double step, State& after) const;
  void find(const NodePaths& paths, double within, std::vector<NodeContact>& found) const;
  void settle(const State& before, double step, std::vector<ContactImpulse>& impulses,
              State& after) const;
  /// (M) Distance of points (M × 3) to the nearest body at a time, negative inside [m]; infinite
  /// where there is no body.
  [[nodiscard]] NodeValues clearance(double time, const NodeVectors& points) const;
  /// The movable node that is deepest inside of a body, thickness included; throws InputError
  /// naming it when it is deeper than `slack` [m].
  void require_outside(const NodeVectors& r, double slack) const;

  /// Distances of points to one body and the normals there; refuses what is not finite.
  void measure(const Body& body, double time, const NodeVectors& points, NodeValues& distance,
               NodeVectors& normal) const;
  /// As Collider::carry.
  [[nodiscard]] bool carry(const Body& body, double from, double to, const NodeVectors& points,
                           NodeVectors& carried) const;
  /// Of paths, at whose ends distances and normals are known: where those come in that have crossed
  /// the body, or its side. The body is where it is at their end, and the paths are as it sees
  /// them.
  [[nodiscard]] std::vector<EntryPlane> crossings(const Body& body, const NodePaths& paths,
                                                  const NodeValues& distance,
                                                  const NodeVectors& normal) const;
  /// Whether a path may lead through a body that its end is `gap` away from.
  [[nodiscard]] bool may_cross(const Body& body, Index node, const Vec3& from, const Vec3& to,
                               double gap, const Vec3& normal) const;
  /// Gap and normal of each movable node, in turn, that is nearer to a body than `within` at the
  /// paths' end.
  template <class Visit>
  void visit_near(const Body& body, const NodePaths& paths, double within,
                  const Visit& visit) const;
  /// The impulses of one body.
  std::vector<ContactImpulse> resolve(std::size_t body, const State& before, double step,
                                      State& after) const;
  /// What there is to settle of some impulses, whose nodes have come with velocities v (N × 3).
  [[nodiscard]] std::vector<Grip> grips(double step, const std::vector<ContactImpulse>& impulses,
                                        const NodeVectors& v, const State& state) const;
  void add_motion(const Body& body, double step, const NodeVectors& points, double time,
                  const std::vector<std::size_t>& of_body, std::vector<Grip>& grips) const;

  std::vector<Body> bodies;
  std::vector<bool> is_convex;
  Mobility mobility;
};

ColliderContact::Impl::Impl(std::vector<Body> of, Index nodes, const ReductionMap& map)
    : bodies(std::move(of)), mobility(map, nodes) {
  for (const Body& body : bodies)
    is_convex.push_back(guarded(body.collider.origin, "saying whether it is convex",
                                [&] { return body.collider.object->is_convex(); }));
}

void ColliderContact::Impl::measure(const Body& body, double time, const NodeVectors& points,
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

bool ColliderContact::Impl::may_cross(const Body& body, Index node, const Vec3& from,
                                      const Vec3& to, double gap, const Vec3& normal) const {
  const double square = (to - from).squaredNorm();
  if ((gap > 0 && gap * gap >= square) || mobility.is_held(node)) return false;
  if (!(square > kNoPath * kNoPath * to.squaredNorm())) return false;
  // A convex body lies behind its tangent plane: a path that begins before it does not enter but
  // where it ends.
  const bool convex = is_convex[static_cast<std::size_t>(&body - bodies.data())];
  return !convex || normal.dot(from - to) + gap < -kOnPlane * std::sqrt(square);
}

bool ColliderContact::Impl::carry(const Body& body, double from, double to,
                                  const NodeVectors& points, NodeVectors& carried) const {
  carried.resize(points.rows(), 3);
  const bool moves = guarded(body.collider.origin, "saying where it carries points", [&] {
    return body.collider.object->carry(from, to, points.rows(), rows_from(points, 0),
                                       rows_from(carried, 0));
  });
  if (moves) require_finite(carried, "a place", body.collider.origin, body.collider.name);
  return moves;
}

std::vector<EntryPlane> ColliderContact::Impl::crossings(const Body& body, const NodePaths& paths,
                                                         const NodeValues& distance,
                                                         const NodeVectors& normal) const {
  if (&paths.from == &paths.to) return {};  // nothing has moved
  NodeVectors carried;
  const bool moves =
      paths.begin != paths.end && carry(body, paths.begin, paths.end, paths.from, carried);
  const NodeVectors &from = moves ? carried : paths.from, &to = paths.to;
  std::vector<Index> nodes;
  for (Index a = 0; a < to.rows(); ++a)
    if (may_cross(body, a, from.row(a).transpose(), to.row(a).transpose(),
                  distance[a] - body.thickness, normal.row(a).transpose()))
      nodes.push_back(a);
  if (nodes.empty()) return {};
  const PathBody seen{[&](const NodeVectors& points, NodeValues& gap, NodeVectors& n) {
                        measure(body, paths.end, points, gap, n);
                        gap.array() -= body.thickness;
                      },
                      is_convex[static_cast<std::size_t>(&body - bodies.data())]};
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
void ColliderContact::Impl::visit_near(const Body& body, const NodePaths& paths, double within,
                                       const Visit& visit) const {
  const NodeVectors& r = paths.to;
  // Kept by each thread from call to call: no allocation once they are large enough.
  thread_local NodeValues distance;
  thread_local NodeVectors normal;
  measure(body, paths.end, r, distance, normal);
  const std::vector<EntryPlane> entries = crossings(body, paths, distance, normal);
  auto entry = entries.begin();
  for (Index a = 0; a < r.rows(); ++a) {
    double gap = distance[a] - body.thickness;
    Vec3 n = normal.row(a).transpose();
    const bool crossed = entry != entries.end() && entry->path == a;
    if (crossed) {
      n = entry->normal;
      gap = (entry++)->gap(r.row(a).transpose());
    }
    const double along = mobility.along(a, n);
    if (gap < within * std::max(1.0, along) && mobility.is_movable(a, n))
      visit(a, gap, n, along, crossed);
  }
}

std::vector<ContactImpulse> ColliderContact::Impl::resolve(const State& before, double step,
                                                           State& after) const {
  std::vector<ContactImpulse> all;
  for (int round = 0; round < kMostRounds; ++round) {
    bool any = false;
    for (std::size_t body = 0; body < bodies.size(); ++body) {
      const std::vector<ContactImpulse> impulses = resolve(body, before, step, after);
      any = any || !impulses.empty();
      all.insert(all.end(), impulses.begin(), impulses.end());
    }
    if (!any || (bodies.size() == 1 && !mobility.has_ties())) break;
  }
  return all;
}

std::vector<ContactImpulse> ColliderContact::Impl::resolve(std::size_t body, const State& before,
                                                           double step, State& after) const {
  NodeVectors earlier;  // where nodes would have been, had they moved with the body
  const bool moves = carry(bodies[body], after.time, after.time - step, after.r, earlier);
  std::vector<ContactImpulse> impulses;
  std::vector<std::pair<Index, Vec3>> moves_of;  // per node, of the unknowns that it follows
  visit_near(bodies[body], {after.time - step, before.r, after.time, after.r}, 0,
             [&](Index a, double gap, const Vec3& n, double /*mobility*/, bool /*crossed*/) {
               Vec3 moved = (after.r.row(a) - before.r.row(a)).transpose();
               Grip grip{
                   .normal = n, .friction = bodies[body].friction, .least = moved.dot(n) - gap};
               if (moves) grip.carried = (after.r.row(a) - earlier.row(a)).transpose();
               moves_of.emplace_back(a, settle_motion(mobility, a, {&grip, 1}, moved));
               impulses.push_back({.node = a, .body = body, .normal = n});
             });
  // What is tied to nodes that are pushed out may come out with them: its turn is the next.
  const auto is_other = [&](const auto& move) { return is_tied(mobility, move.first); };
  if (mobility.has_ties() && !std::ranges::all_of(moves_of, is_other)) {
    std::erase_if(moves_of, is_other);
    std::erase_if(impulses, [&](const ContactImpulse& i) { return is_tied(mobility, i.node); });
  }
  for (const auto& [node, move] : moves_of) mobility.add(node, move, after.r);
  if (!impulses.empty() && mobility.has_ties()) mobility.map().complete_positions(after.r);
  settle(before, step, impulses, after);
  return impulses;
}

void ColliderContact::Impl::find(const NodePaths& paths, double within,
                                 std::vector<NodeContact>& found) const {
  found.clear();
  for (std::size_t b = 0; b < bodies.size(); ++b)
    visit_near(bodies[b], paths, within,
               [&](Index a, double gap, const Vec3& n, double along, bool crossed) {
                 found.push_back({a, b, gap, n, bodies[b].friction, along, crossed});
               });
}

std::vector<Grip> ColliderContact::Impl::grips(double step,
                                               const std::vector<ContactImpulse>& impulses,
                                               const NodeVectors& v, const State& state) const {
  std::vector<Grip> grips;
  for (const ContactImpulse& i : impulses)
    grips.push_back({.normal = i.normal,
                     .friction = bodies[i.body].friction,
                     .normal_impulse = i.normal_impulse,
                     .friction_impulse = i.friction_impulse});
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    std::vector<std::size_t> of_body;
    for (std::size_t k = 0; k < impulses.size(); ++k)
      if (impulses[k].body == b) of_body.push_back(k);
    if (of_body.empty()) continue;
    NodeVectors points(static_cast<Index>(of_body.size()), 3);
    for (std::size_t k = 0; k < of_body.size(); ++k)
      points.row(static_cast<Index>(k)) = state.r.row(impulses[of_body[k]].node);
    add_motion(bodies[b], step, points, state.time, of_body, grips);
    for (const std::size_t k : of_body) {
      const double approach =
          grips[k].least - grips[k].normal.dot(Vec3(v.row(impulses[k].node).transpose()));
      grips[k].least += bodies[b].restitution * std::max(approach, 0.0);
    }
  }
  return grips;
}

/// A body's velocity at points that its contacts `of_body` are at: along the normal that of its
/// surface, across it that of what it carries.
void ColliderContact::Impl::add_motion(const Body& body, double step, const NodeVectors& points,
                                       double time, const std::vector<std::size_t>& of_body,
                                       std::vector<Grip>& grips) const {
  NodeValues now, before;
  NodeVectors normal, earlier;
  measure(body, time, points, now, normal);
  measure(body, time - step, points, before, normal);
  const bool moves = carry(body, time, time - step, points, earlier);
  for (std::size_t k = 0; k < of_body.size(); ++k) {
    const auto row = static_cast<Index>(k);
    Grip& grip = grips[of_body[k]];
    grip.least = (before[row] - now[row]) / step;
    if (moves) grip.carried = (points.row(row) - earlier.row(row)).transpose() / step;
  }
}

void ColliderContact::Impl::settle(const State& before, double step,
                                   std::vector<ContactImpulse>& impulses, State& after) const {
  if (impulses.empty()) return;
  const std::vector<Grip> all = grips(step, impulses, before.v, after);
  std::vector<std::size_t> by_node(impulses.size());
  std::iota(by_node.begin(), by_node.end(), std::size_t{0});
  const auto node_of = [&](std::size_t i) { return impulses[i].node; };
  std::ranges::stable_sort(by_node, {}, node_of);
  // Nodes that are tied to others come after these: most have what they need then.
  if (mobility.has_ties())
    std::stable_partition(by_node.begin(), by_node.end(),
                          [&](std::size_t i) { return !is_tied(mobility, node_of(i)); });
  std::vector<Grip> of_node;
  for (std::size_t k = 0, end = 0; k < by_node.size(); k = end) {
    const Index node = node_of(by_node[k]);
    of_node.clear();
    for (end = k; end < by_node.size() && node_of(by_node[end]) == node; ++end)
      of_node.push_back(all[by_node[end]]);
    if (mobility.has_ties() && is_tied(mobility, node)) mobility.map().complete_changes(after.v);
    Vec3 v = after.v.row(node).transpose();
    mobility.add(node, settle_motion(mobility, node, of_node, v), after.v);
    for (std::size_t i = k; i < end; ++i) {
      impulses[by_node[i]].normal_impulse = of_node[i - k].normal_impulse;
      impulses[by_node[i]].friction_impulse = of_node[i - k].friction_impulse;
    }
  }
  if (mobility.has_ties()) mobility.map().complete_changes(after.v);
}

NodeValues ColliderContact::Impl::clearance(double time, const NodeVectors& points) const {
  NodeValues least = NodeValues::Constant(points.rows(), std::numeric_limits<double>::infinity());
  NodeValues distance;
  NodeVectors normal;
  for (const Body& body : bodies) {
    measure(body, time, points, distance, normal);
    least = least.cwiseMin(distance);
  }
  return least;
}

void ColliderContact::Impl::require_outside(const NodeVectors& r, double slack) const {
  NodeValues distance;
  NodeVectors normal;
  std::vector<Problem> problems;
  for (const Body& body : bodies) {
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
          mobility.is_movable(a, normal.row(a).transpose()))
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

ColliderContact::ColliderContact(std::vector<Body> bodies, Index nodes, const ReductionMap& map)
    : impl_(std::make_unique<Impl>(std::move(bodies), nodes, map)) {}
ColliderContact::~ColliderContact() = default;
std::size_t ColliderContact::bodies() const { return impl_->bodies.size(); }
const Mobility& ColliderContact::mobility() const { return impl_->mobility; }
std::vector<ContactImpulse> ColliderContact::resolve(const State& before, double step,
                                                     State& after) const {
  return impl_->resolve(before, step, after);
}
void ColliderContact::find(const NodePaths& paths, double within,
                           std::vector<NodeContact>& found) const {
  impl_->find(paths, within, found);
}
void ColliderContact::settle(const State& before, double step,
                             std::vector<ContactImpulse>& impulses, State& after) const {
  impl_->settle(before, step, impulses, after);
}
bool ColliderContact::carry(std::size_t body, double from, double to, const NodeVectors& r,
                            NodeVectors& carried) const {
  return impl_->carry(impl_->bodies[body], from, to, r, carried);
}
NodeValues ColliderContact::clearance(double time, const NodeVectors& points) const {
  return impl_->clearance(time, points);
}
void ColliderContact::require_outside(const NodeVectors& r, double slack) const {
  impl_->require_outside(r, slack);
}

}  // namespace deform
