#include "solve/contact/active_contacts.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "deform/geometry/rounding.h"

namespace deform {
namespace {

/// What is nearer to a body than this part of the surface's size touches it.
constexpr double kTouching = 1e-12;
/// Penalties as multiples of a node's own stiffness: what a direction leaves of a constraint is
/// about the inverse of that, and then put right by the projection.
constexpr double kPenalty = 20;
/// Likewise of friction: softer ones make its kinks rounder, and updates of T̂ put the rest right.
constexpr double kFrictionPenalty = 1;
/// What was about to touch does so after a step that leaves no more of the gap than this part of
/// the node's motion: what a curved body, or a path that turns, makes of it.
constexpr double kBent = 0.1;
/// Where no larger part of the active set changes, the projection makes it good.
constexpr double kFew = 0.1;
/// A direction may take a node in by this part of its motion.
constexpr double kComesIn = 1e-3;
/// An impulse is an impact's where the velocity that a stage begins with is this part of it, or
/// more: all of it stops that, or, by the midpoint rule, half of it.
constexpr double kOfAnImpact = 0.4;
/// Out of one body a node may come into another one.
constexpr int kMostRounds = 8;
/// Reactions of contacts that push against each other take a few turns.
constexpr int kMostTurns = 50;
constexpr double kBalanced = 1e-13;
/// More colliders than any scene has.
constexpr std::size_t kMostBodies = 1 << 20;
constexpr std::size_t kMostNodes = std::size_t{1} << 40;

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

using Place = std::pair<std::size_t, Index>;  // collider, node
Place place_of(const NodeContact& c) { return {c.body, c.node}; }

/// The one at a place among some in the order of places; null where there is none.
template <class Items>
auto* at_place(Items& items, const Place& place) {
  const auto at =
      std::ranges::lower_bound(items, place, {}, [](const auto& item) { return item.place(); });
  return at != items.end() && at->place() == place ? &*at : nullptr;
}

}  // namespace

void ActiveContacts::begin(const ColliderContact& contact, const Stage& stage, double size,
                           const NodeValues& stiffness) {
  contact_ = &contact;
  stage_ = &stage;
  penalty_ = kPenalty * stiffness;
  friction_penalty_ = kFrictionPenalty * stiffness;
  touching_ = kTouching * size + 4 * rounding_of_positions(stage.start);
  normal_.clear();
  predicted_.clear();
  planes_.clear();
  at_ = stage.start;
  carried_.resize(contact.bodies());
  for (std::size_t b = 0; b < contact.bodies(); ++b) {
    if (contact.carry(b, stage.begin, stage.end, stage.start, carried_[b]))
      carried_[b] -= stage.start;
    else
      carried_[b].resize(0, 3);
  }
  std::erase_if(friction_, [](const Friction& f) { return f.ends; });
  for (Friction& f : friction_) {
    if (f.body >= contact.bodies() || f.node >= at_.rows())
      throw InputError("the checkpoint's \"contact.friction\" is of another scene's contact");
    f.sliding = sliding(f.node, f.normal);
  }
}

const NodeVectors& ActiveContacts::end_of(const NodeVectors& r) const {
  end_ = stage_->start + stage_->reach * (r - stage_->start);
  return end_;
}

void ActiveContacts::find(const NodeVectors& end, double within,
                          std::vector<NodeContact>& found) const {
  contact_->find({stage_->end, end, stage_->end, end}, within, found);
  if (planes_.empty()) return;
  std::erase_if(found, [&](const NodeContact& c) {
    return std::ranges::binary_search(planes_, place_of(c), {}, &Plane::place);
  });
  for (const Plane& plane : planes_) {
    NodeContact c = plane.contact;
    c.gap = c.normal.dot(Vec3(end.row(c.node).transpose())) - plane.offset;
    if (c.gap < within) found.push_back(c);
  }
  std::ranges::sort(found, {}, place_of);
}

Eigen::Matrix3d ActiveContacts::sliding(Index node, const Vec3& n) const {
  Eigen::Matrix3d projection;
  for (int c = 0; c < 3; ++c)
    projection.col(c) = contact_->mobility().sliding(node, n, Vec3::Unit(c));
  return projection;
}

ActiveContacts::Friction ActiveContacts::friction_of(const NodeContact& c, double force) const {
  return {.node = c.node,
          .body = c.body,
          .normal = c.normal,
          .sliding = sliding(c.node, c.normal),
          .limit = c.friction * force};
}

/// u_T at positions r of the stage.
Vec3 ActiveContacts::slid(const Friction& f, const NodeVectors& r) const {
  Vec3 moved = stage_->reach * (r.row(f.node) - stage_->start.row(f.node)).transpose();
  if (carried_[f.body].rows() > 0) moved -= carried_[f.body].row(f.node).transpose();
  return f.sliding * moved;
}

/// T̂ − κ u_T at positions r of the stage.
Vec3 ActiveContacts::trial_of(const Friction& f, const NodeVectors& r) const {
  return f.kept - friction_penalty_[f.node] * slid(f, r);
}

void ActiveContacts::act(Friction& f, const NodeVectors& r) const {
  f.trial = trial_of(f, r);
  f.force = f.sticks() ? f.trial : Vec3(f.limit / f.trial.norm() * f.trial);
}

/// Moves a node's position at the end of the stage, as far as it is free, by R Rᵀ times a vector.
void ActiveContacts::move(Index node, const Vec3& by, NodeVectors& r) const {
  contact_->mobility().add(node, by / stage_->reach, r);
}

void ActiveContacts::push_out(NodeVectors& r) const {
  for (int round = 0; round < kMostRounds; ++round) {
    const double farthest = round == 0 ? stage_->reach * (r - at_).rowwise().norm().maxCoeff() : 0;
    find(end_of(r), farthest, near_);
    bool any = false;
    for (const NodeContact& c : near_) {
      const Normal* normal = round == 0 ? at_place(normal_, place_of(c)) : nullptr;
      const double moved = stage_->reach * (r.row(c.node) - at_.row(c.node)).norm();
      const bool is_held =
          normal != nullptr && normal->penalty > 0 && (!normal->is_ahead || c.gap <= kBent * moved);
      if (!(c.gap < 0 || is_held)) continue;
      move(c.node, -c.gap / c.mobility * c.normal, r);
      any = any || c.gap < -touching_;
    }
    if (!any) break;
  }
}

void ActiveContacts::confine(NodeVectors& r) const {
  push_out(r);
  if (contact_->mobility().has_ties()) contact_->mobility().map().complete_positions(r);
}

double ActiveContacts::dissipation(const NodeVectors& r) const {
  double sum = 0;
  for (const Friction& f : friction_) {
    const double length = trial_of(f, r).norm();
    const double slide =
        length <= f.limit ? 0.5 * length * length : f.limit * (length - 0.5 * f.limit);
    sum += slide / (friction_penalty_[f.node] * stage_->reach);
  }
  return sum;
}

bool ActiveContacts::react(const NodeVectors& r, NodeVectors& residual) {
  at_ = r;
  find(end_of(r), touching_, near_);
  normal_.clear();
  for (const NodeContact& c : near_)
    normal_.push_back({.contact = c, .is_ahead = c.gap < -touching_});
  const auto add_force = [&](Friction& f) {
    act(f, r);
    contact_->mobility().add(f.node, f.force, residual);
  };
  for (Friction& f : friction_) add_force(f);
  balance(residual);
  updated_.clear();
  for (const Normal& n : normal_)
    if (n.force > 0 && n.contact.friction > 0 && at_place(friction_, n.place()) == nullptr)
      updated_.push_back(friction_of(n.contact, n.force));
  if (updated_.empty()) return false;
  for (Friction& f : updated_) add_force(f);
  balance(residual);
  friction_.insert(friction_.end(), updated_.begin(), updated_.end());
  std::ranges::sort(friction_, {}, &Friction::place);
  return true;
}

/// By turns (projected Gauss–Seidel); at once where each node touches one body.
void ActiveContacts::balance(NodeVectors& residual) {
  const Mobility& mobility = contact_->mobility();
  for (int turn = 0; turn < kMostTurns; ++turn) {
    double largest = 0, sum = 0;
    for (Normal& n : normal_) {
      const NodeContact& c = n.contact;
      const double more =
          std::max(-n.force, -c.normal.dot(mobility.motion(c.node, residual)) / c.mobility);
      n.force += more;
      mobility.add(c.node, more * c.normal, residual);
      largest = std::max(largest, std::abs(more));
      sum = std::max(sum, n.force);
    }
    if (largest <= kBalanced * sum) break;
  }
}

void ActiveContacts::begin_direction() {
  for (Normal& n : normal_)
    n.penalty = n.force > 0 ? penalty_[n.contact.node] / n.contact.mobility : 0;
  if (predicted_.empty()) return;
  find(end_of(at_), farthest_, near_);
  ahead_.clear();
  for (const NodeContact& c : near_)
    if (std::ranges::binary_search(predicted_, place_of(c)) &&
        at_place(normal_, place_of(c)) == nullptr)
      ahead_.push_back({.contact = c, .penalty = penalty_[c.node] / c.mobility, .is_ahead = true});
  add_ahead();
}

const std::vector<BlockEntry>& ActiveContacts::tangent() {
  tangent_.clear();
  for (const Normal& n : normal_) {
    const Vec3& normal = n.contact.normal;
    if (n.penalty > 0)
      tangent_.push_back({n.contact.node, n.contact.node, n.penalty * normal * normal.transpose()});
  }
  for (const Friction& f : friction_) {
    Eigen::Matrix3d k = f.sliding;
    if (!f.sticks()) {
      const Vec3 along = f.trial.normalized();
      k = f.limit / f.trial.norm() * (k - along * along.transpose());
    }
    tangent_.push_back({f.node, f.node, friction_penalty_[f.node] * stage_->reach * k});
  }
  return tangent_;
}

void ActiveContacts::add_targets(NodeVectors& residual) const {
  for (const Normal& n : normal_)
    if (n.penalty > 0 && n.is_ahead)
      contact_->mobility().add(
          n.contact.node, -n.penalty * n.contact.gap / stage_->reach * n.contact.normal, residual);
}

bool ActiveContacts::revise(const NodeVectors& r, const NodeVectors& direction) {
  std::size_t changed = 0;
  for (Normal& n : normal_) {
    const NodeContact& c = n.contact;
    const double along = c.normal.dot(Vec3(direction.row(c.node).transpose()));
    if (n.penalty > 0 && n.force + n.penalty * (-c.gap / stage_->reach - along) < 0) {
      n.penalty = 0;
      ++changed;
    }
  }
  farthest_ = stage_->reach * direction.rowwise().norm().maxCoeff();
  find(end_of(r), farthest_, near_);
  ahead_.clear();
  for (const NodeContact& c : near_) {
    const Vec3 d = stage_->reach * direction.row(c.node).transpose();
    if (!(c.gap + c.normal.dot(d) < -kComesIn * d.norm())) continue;
    Normal* const known = at_place(normal_, place_of(c));
    if (known == nullptr)
      ahead_.push_back({.contact = c, .penalty = penalty_[c.node] / c.mobility, .is_ahead = true});
    else if (known->penalty == 0)
      known->penalty = penalty_[c.node] / c.mobility;
    else
      continue;
    ++changed;
  }
  add_ahead();
  predicted_.clear();
  for (const Normal& n : normal_)
    if (n.is_ahead && n.penalty > 0) predicted_.push_back(n.place());
  return static_cast<double>(changed) > kFew * static_cast<double>(normal_.size());
}

void ActiveContacts::add_ahead() {
  normal_.insert(normal_.end(), ahead_.begin(), ahead_.end());
  std::ranges::sort(normal_, {}, &Normal::place);
}

void ActiveContacts::drop_predicted() {
  predicted_.clear();
  std::erase_if(normal_, [](const Normal& n) { return n.is_ahead; });
}

bool ActiveContacts::add_planes(const NodeVectors& end) {
  contact_->find({stage_->begin, stage_->start, stage_->end, end}, touching_, near_);
  const auto known = static_cast<std::ptrdiff_t>(planes_.size());
  for (const NodeContact& c : near_) {
    const auto begin = planes_.begin();
    if (!c.crossed ||
        std::ranges::binary_search(begin, begin + known, place_of(c), {}, &Plane::place))
      continue;
    planes_.push_back({c, c.normal.dot(Vec3(end.row(c.node).transpose())) - c.gap});
    // What there was is of the side that is nearest.
    std::erase_if(friction_, [&](const Friction& f) { return f.place() == place_of(c); });
    std::erase_if(normal_, [&](const Normal& n) { return n.place() == place_of(c); });
  }
  std::ranges::sort(planes_, {}, &Plane::place);
  return std::ssize(planes_) > known;
}

bool ActiveContacts::update(const NodeVectors& r) {
  updated_.clear();
  for (const Normal& n : normal_) {
    if (!(n.force > 0 && n.contact.friction > 0)) continue;
    Friction friction = friction_of(n.contact, n.force);
    if (const Friction* before = at_place(friction_, n.place()))
      friction.kept = friction.sliding * before->force;
    act(friction, r);
    updated_.push_back(friction);
  }
  note_changes(r.rows());
  std::swap(friction_, updated_);
  return add_planes(end_of(r));
}

/// How far what changes of friction would move each node, by its stiffness.
void ActiveContacts::note_changes(Index nodes) {
  change_.setZero(nodes, 3);
  for (const Friction& f : friction_) change_.row(f.node) -= f.force.transpose();
  for (const Friction& f : updated_) change_.row(f.node) += f.force.transpose();
  unsettled_ = kFrictionPenalty * change_.rowwise().norm().cwiseQuotient(friction_penalty_);
}

double ActiveContacts::unsettled(const NodeValues& mass) const {
  return std::sqrt(mass.dot(unsettled_.cwiseAbs2()) / mass.sum());
}

void ActiveContacts::forget_impacts(const Stage& stage, const NodeValues& mass) {
  for (const ContactImpulse& i : impulses(stage, mass)) {
    const double approach = -i.normal.dot(Vec3(stage.v_base.row(i.node).transpose()));
    if (!(approach > kOfAnImpact * i.normal_impulse)) continue;
    if (Friction* friction = at_place(friction_, {i.body, i.node})) friction->ends = true;
  }
}

std::vector<Index> ActiveContacts::active_nodes() const {
  std::vector<Index> all;
  for (const Normal& n : normal_)
    if (n.force > 0) all.push_back(n.contact.node);
  std::ranges::sort(all);
  return all;
}

/// M Δv = reach τ (N n + T): where the stage's end is not the step's, the rest of the step goes on
/// with the same forces.
std::vector<ContactImpulse> ActiveContacts::impulses(const Stage& stage,
                                                     const NodeValues& mass) const {
  std::vector<ContactImpulse> all;
  for (const Normal& n : normal_) {
    if (!(n.force > 0)) continue;
    const NodeContact& c = n.contact;
    const double per_force = stage.reach * stage.tau / mass[c.node];
    const Friction* f = at_place(friction_, n.place());
    all.push_back({c.node, c.body, c.normal, per_force * n.force,
                   f != nullptr ? Vec3(per_force * f->force) : Vec3(Vec3::Zero())});
  }
  return all;
}

/// Of each node and collider: normal, disk, T̂.
void ActiveContacts::save(Memory& memory) const {
  std::vector<double> all;
  for (const Friction& f : friction_) {
    if (f.ends) continue;
    all.insert(all.end(), {static_cast<double>(f.node), static_cast<double>(f.body)});
    all.insert(all.end(), f.normal.begin(), f.normal.end());
    all.push_back(f.limit);
    all.insert(all.end(), f.kept.begin(), f.kept.end());
  }
  memory.put("contact.friction", std::move(all));
  memory.put("contact.nodes", {static_cast<double>(at_.rows())});
}

void ActiveContacts::load(const Memory& memory) {
  const double nodes = memory.get("contact.nodes", 1).front();
  if (!is_number_below(nodes, kMostNodes))
    throw InputError(fmt::format("the checkpoint's \"contact.nodes\" is {:g}", nodes));
  load_friction(finite_numbers(memory, "contact.friction"), static_cast<std::size_t>(nodes));
}

void ActiveContacts::load_friction(const std::vector<double>& all, std::size_t nodes) {
  constexpr std::size_t kNumbers = 9;
  if (all.size() % kNumbers != 0)
    throw InputError("the checkpoint's \"contact.friction\" has " + std::to_string(all.size()) +
                     " numbers, expected a multiple of " + std::to_string(kNumbers));
  friction_.clear();
  for (std::size_t i = 0; i < all.size(); i += kNumbers) {
    const double* x = all.data() + i;
    if (!is_number_below(x[0], nodes) || !is_number_below(x[1], kMostBodies))
      throw InputError(
          fmt::format("the checkpoint's \"contact.friction\" is of node {:g} and collider {:g}, "
                      "expected whole numbers from 0, the first below {}",
                      x[0], x[1], nodes));
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

}  // namespace deform
