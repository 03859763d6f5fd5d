#include "solve/contact/contact_multipliers.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include <fmt/format.h>

namespace deform {
namespace {

/// Penalties as multiples of a node's own stiffness: an update of the multipliers then leaves about
/// a tenth of their error, and the matrix stays well conditioned.
constexpr double kPenalty = 10;
/// An impulse is an impact's where the velocity that a stage begins with is this part of it, or
/// more: all of it stops that, or, by the midpoint rule, half of it.
constexpr double kOfAnImpact = 0.4;

const std::vector<double>& finite_numbers(const Memory& memory, const std::string& name) {
  const auto entry = memory.entries().find(name);
  if (entry == memory.entries().end()) throw InputError("the checkpoint has no \"" + name + '"');
  if (!std::ranges::all_of(entry->second, [](double x) { return std::isfinite(x); }))
    throw InputError("the checkpoint's \"" + name + "\" has a number that is not finite");
  return entry->second;
}

bool is_number_below(double x, std::size_t end) {
  return x >= 0 && x < static_cast<double>(end) && x == std::floor(x);
}

/// Collider by collider, nodes ascending.
std::pair<std::size_t, Index> place(const NodeContact& c) { return {c.body, c.node}; }

}  // namespace

void ContactMultipliers::begin(const ColliderContact& contact, const NodeValues& stiffness) {
  contact_ = &contact;
  penalty_ = kPenalty * stiffness;
  nodes_ = stiffness.size();
  planes_.clear();
  const std::size_t size = contact.bodies() * static_cast<std::size_t>(nodes_);
  if (lambda_.empty()) lambda_.assign(size, 0.0);
  if (lambda_.size() != size)
    throw InputError(
        fmt::format("the checkpoint's \"contact.lambda\" has {} numbers, expected {} "
                    "colliders times {} nodes",
                    lambda_.size(), contact.bodies(), nodes_));
  std::erase_if(friction_,
                [&](const Friction& f) { return lambda_[place_of(f.body, f.node)] == 0; });
  for (Friction& f : friction_) f.sliding = sliding(f.node, f.normal);
}

NodeVectors ContactMultipliers::end_of(const Stage& stage, const NodeVectors& r) {
  return stage.start + stage.reach * (r - stage.start);
}

Eigen::Matrix3d ContactMultipliers::sliding(Index node, const Vec3& n) const {
  Eigen::Matrix3d projection;
  for (int c = 0; c < 3; ++c)
    projection.col(c) = contact_->mobility().sliding(node, n, Vec3::Unit(c));
  return projection;
}

bool ContactMultipliers::add_planes(const Stage& stage, const NodeVectors& end) {
  std::vector<NodeContact> near;
  contact_->find(stage.end, stage.start, end, 0, near);
  const auto known = static_cast<std::ptrdiff_t>(planes_.size());
  for (const NodeContact& c : near) {
    const auto begin = planes_.begin();
    if (!c.crossed || std::ranges::binary_search(begin, begin + known, place(c), {}, &Plane::place))
      continue;
    planes_.push_back({c, c.normal.dot(Vec3(end.row(c.node).transpose())) - c.gap});
    lambda(c) = 0;  // what there was is of the side that is nearest
    std::erase_if(friction_,
                  [&](const Friction& r) { return r.node == c.node && r.body == c.body; });
  }
  std::ranges::sort(planes_, {}, &Plane::place);
  return std::ssize(planes_) > known;
}

void ContactMultipliers::use_planes(const NodeVectors& end, std::vector<NodeContact>& near) const {
  if (planes_.empty()) return;
  std::erase_if(near, [&](const NodeContact& c) {
    return std::ranges::binary_search(planes_, place(c), {}, &Plane::place);
  });
  for (const Plane& plane : planes_) {
    const NodeContact& c = plane.contact;
    near.push_back(c);
    near.back().gap = c.normal.dot(Vec3(end.row(c.node).transpose())) - plane.offset;
  }
  std::ranges::sort(near, {}, place);
}

void ContactMultipliers::find(const Stage& stage, const NodeVectors& r) {
  reach_ = stage.reach;
  const NodeVectors end = end_of(stage, r);
  double within = 0;
  for (std::size_t i = 0; i < lambda_.size(); ++i)
    within = std::max(within, lambda_[i] / penalty_[static_cast<Index>(i) % nodes_]);
  std::vector<NodeContact> near;
  contact_->find(stage.end, end, end, within, near);
  use_planes(end, near);
  normal_.clear();
  for (const NodeContact& c : near)
    if (const double force = lambda(c) - penalty(c) * c.gap; force > 0)
      normal_.push_back({c, force});
  for (Friction& friction : friction_) {
    const Vec3 moved = (end.row(friction.node) - stage.start.row(friction.node)).transpose();
    friction.trial = friction.kept - penalty_[friction.node] * (friction.sliding * moved);
    friction.force = friction.sticks()
                         ? friction.trial
                         : Vec3(friction.limit / friction.trial.norm() * friction.trial);
  }
}

const ContactMultipliers::Friction* ContactMultipliers::friction_of(const NodeContact& c) const {
  const auto at =
      std::ranges::lower_bound(friction_, std::pair(c.body, c.node), {},
                               [](const Friction& r) { return std::pair(r.body, r.node); });
  return at != friction_.end() && at->body == c.body && at->node == c.node ? &*at : nullptr;
}

std::vector<Index> ContactMultipliers::active_nodes() const {
  std::vector<Index> all;
  for (const NormalForce& normal : normal_) all.push_back(normal.contact.node);
  std::ranges::sort(all);
  return all;
}

/// M Δv = reach τ (N n + T): where the stage's end is not the step's, the rest of the step goes on
/// with the same forces.
std::vector<ContactImpulse> ContactMultipliers::impulses(const Stage& stage,
                                                         const NodeValues& mass) const {
  std::vector<ContactImpulse> all;
  for (const NormalForce& normal : normal_) {
    const NodeContact& c = normal.contact;
    const double per_force = stage.reach * stage.tau / mass[c.node];
    const Friction* friction = friction_of(c);
    all.push_back({c.node, c.body, c.normal, per_force * normal.force,
                   friction == nullptr ? Vec3(Vec3::Zero()) : Vec3(per_force * friction->force)});
  }
  return all;
}

void ContactMultipliers::forget_impacts(const Stage& stage, const NodeValues& mass) {
  for (const ContactImpulse& i : impulses(stage, mass)) {
    const double approach = -i.normal.dot(Vec3(stage.v_base.row(i.node).transpose()));
    if (approach > kOfAnImpact * i.normal_impulse) lambda_[place_of(i.body, i.node)] = 0;
  }
}

void ContactMultipliers::add_force(NodeVectors& f) const {
  for (const NormalForce& normal : normal_)
    f.row(normal.contact.node) += normal.force * normal.contact.normal.transpose();
  for (const Friction& friction : friction_) f.row(friction.node) += friction.force.transpose();
}

const std::vector<BlockEntry>& ContactMultipliers::tangent() {
  tangent_.clear();
  for (const NormalForce& normal : normal_) {
    const Vec3& n = normal.contact.normal;
    const Index a = normal.contact.node;
    tangent_.push_back({a, a, penalty(normal.contact) * reach_ * n * n.transpose()});
  }
  for (const Friction& friction : friction_) {
    Eigen::Matrix3d k = friction.sliding;
    if (!friction.sticks()) {
      const Vec3 along = friction.trial.normalized();
      k = friction.limit / friction.trial.norm() * (k - along * along.transpose());
    }
    tangent_.push_back({friction.node, friction.node, penalty_[friction.node] * reach_ * k});
  }
  return tangent_;
}

double ContactMultipliers::potential() const {
  double sum = 0;
  for (const NormalForce& normal : normal_)
    sum += 0.5 * normal.force * normal.force / (penalty(normal.contact) * reach_);
  for (const Friction& friction : friction_) {
    const double length = friction.trial.norm();
    const double slide = friction.sticks() ? 0.5 * length * length
                                           : friction.limit * (length - 0.5 * friction.limit);
    sum += slide / (penalty_[friction.node] * reach_);
  }
  return sum;
}

bool ContactMultipliers::update(const Stage& stage, const NodeVectors& r) {
  std::vector<Friction> frictions;
  std::ranges::fill(lambda_, 0.0);
  for (const NormalForce& normal : normal_) {
    const NodeContact& c = normal.contact;
    lambda(c) = normal.force;
    if (c.friction == 0) continue;
    const Friction* before = friction_of(c);
    Friction friction{.node = c.node,
                      .body = c.body,
                      .normal = c.normal,
                      .sliding = sliding(c.node, c.normal),
                      .limit = c.friction * normal.force};
    if (before != nullptr) friction.kept = friction.sliding * before->force;
    frictions.push_back(friction);
  }
  friction_ = std::move(frictions);
  const bool has_new_planes = add_planes(stage, end_of(stage, r));
  find(stage, r);
  return has_new_planes;
}

/// For each multiplier collider, node, λ, λ_T, normal and disk.
void ContactMultipliers::save(Memory& memory) const {
  memory.put("contact.lambda", lambda_);
  std::vector<double> all;
  for (const Friction& r : friction_)
    for (const double x : {static_cast<double>(r.node), static_cast<double>(r.body), r.normal.x(),
                           r.normal.y(), r.normal.z(), r.limit, r.kept.x(), r.kept.y(), r.kept.z()})
      all.push_back(x);
  memory.put("contact.friction", std::move(all));
}

void ContactMultipliers::load(const Memory& memory) {
  lambda_ = finite_numbers(memory, "contact.lambda");
  if (std::ranges::any_of(lambda_, [](double x) { return x < 0; }))
    throw InputError("the checkpoint's \"contact.lambda\" has a number below 0");
  const auto last = memory.entries().find("last.r");  // of the step that they are of
  const std::size_t nodes = last == memory.entries().end() ? 0 : last->second.size() / 3;
  if (nodes > 0 && lambda_.size() % nodes != 0)
    throw InputError(
        fmt::format("the checkpoint's \"contact.lambda\" has {} numbers, expected a "
                    "multiple of the number of nodes, {}",
                    lambda_.size(), nodes));
  load_friction(finite_numbers(memory, "contact.friction"), nodes);
}

void ContactMultipliers::load_friction(const std::vector<double>& all, std::size_t nodes) {
  constexpr std::size_t kNumbers = 9;
  if (all.size() % kNumbers != 0)
    throw InputError("the checkpoint's \"contact.friction\" has " + std::to_string(all.size()) +
                     " numbers, expected a multiple of " + std::to_string(kNumbers));
  const std::size_t bodies = nodes == 0 ? 0 : lambda_.size() / nodes;
  friction_.clear();
  for (std::size_t i = 0; i < all.size(); i += kNumbers) {
    const double* x = all.data() + i;
    if (!is_number_below(x[0], nodes) || !is_number_below(x[1], bodies))
      throw InputError(
          fmt::format("the checkpoint's \"contact.friction\" is of node {:g} and collider {:g}, "
                      "expected whole numbers from 0, below {} and {}",
                      x[0], x[1], nodes, bodies));
    if (!(x[5] >= 0))
      throw InputError(
          fmt::format("the checkpoint's \"contact.friction\" has a limit of {:g}", x[5]));
    const Friction friction{.node = static_cast<Index>(x[0]),
                            .body = static_cast<std::size_t>(x[1]),
                            .normal = {x[2], x[3], x[4]},
                            .limit = x[5],
                            .kept = {x[6], x[7], x[8]}};
    if (!friction_.empty() && std::pair(friction.body, friction.node) <=
                                  std::pair(friction_.back().body, friction_.back().node))
      throw InputError(
          "the checkpoint's \"contact.friction\" is not in the order of colliders and nodes");
    friction_.push_back(friction);
  }
}

void ContactMultipliers::forget() {
  lambda_.clear();
  normal_.clear();
  friction_.clear();
  planes_.clear();
}

}  // namespace deform
