#include "solve/contact/contact_law.h"

#include <algorithm>

#include <Eigen/Eigenvalues>

namespace deform {
namespace {

/// Contacts of a node that push against each other take a few turns.
constexpr int kMostTurns = 30;
/// A change of this part of the motion ends them.
constexpr double kSettled = 1e-12;
/// Part of the largest eigenvalue of R Rᵀ below which one is 0.
constexpr double kNoMotion = 1e-12;

/// One contact's turn; returns the change of its impulse.
Vec3 settle_one(const Mobility& mobility, Index node, Grip& grip, Vec3& motion) {
  const Vec3& n = grip.normal;
  const double more =
      std::max(-grip.normal_impulse, (grip.least - motion.dot(n)) / mobility.along(node, n));
  grip.normal_impulse += more;
  motion += mobility.response(node, more * n);
  const Vec3 slip = mobility.sliding(node, n, motion - grip.carried);
  Vec3 friction = grip.friction_impulse - slip / mobility.bound(node);
  const double limit = grip.friction * grip.normal_impulse, length = friction.norm();
  if (length > limit) friction *= limit / length;
  const Vec3 change = friction - grip.friction_impulse;
  grip.friction_impulse = friction;
  motion += mobility.response(node, change);
  return more * n + change;
}

}  // namespace

Mobility::Mobility(const ReductionMap& map, Index nodes) : map_(&map) {
  const Reduction& reduction = map.reduction();
  kind_.assign(static_cast<std::size_t>(reduction.nodes()), kHeld);
  for (Index a = 0; a < nodes; ++a) {
    kind_[static_cast<std::size_t>(a)] = kFree;
    if (reduction.free(a, 0) && reduction.free(a, 1) && reduction.free(a, 2)) continue;
    Partly p;
    for (int c = 0; c < 3; ++c) p.rows[static_cast<std::size_t>(c)] = map.row({a, c});
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) {
        p.matrix(i, j) = 0;
        for (const Tie::Part& x : p.rows[static_cast<std::size_t>(i)])
          for (const Tie::Part& y : p.rows[static_cast<std::size_t>(j)])
            if (x.of == y.of) p.matrix(i, j) += x.coefficient * y.coefficient;
      }
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> modes(p.matrix);
    p.bound = std::max(1.0, modes.eigenvalues().maxCoeff());
    p.range.setZero();
    for (Index i = 0; i < 3; ++i)
      if (modes.eigenvalues()[i] > kNoMotion * p.bound)
        p.range += modes.eigenvectors().col(i) * modes.eigenvectors().col(i).transpose();
    const bool is_held = p.matrix.isZero(0);
    kind_[static_cast<std::size_t>(a)] =
        is_held ? kHeld : static_cast<std::int32_t>(partly_.size());
    if (!is_held) partly_.push_back(std::move(p));
  }
}

Vec3 Mobility::sliding(Index node, const Vec3& n, const Vec3& motion) const {
  if (kind(node) == kFree) return motion - motion.dot(n) * n;
  if (kind(node) == kHeld) return Vec3::Zero();
  const Vec3 m = of(node).range * n, own = of(node).range * motion;
  const double square = m.squaredNorm();
  return square > 0 ? Vec3(own - own.dot(m) / square * m) : own;
}

Vec3 Mobility::motion(Index node, const NodeVectors& field) const {
  if (kind(node) == kFree) return field.row(node).transpose();
  Vec3 sum = Vec3::Zero();
  if (kind(node) == kHeld) return sum;
  for (int c = 0; c < 3; ++c)
    for (const Tie::Part& part : of(node).rows[static_cast<std::size_t>(c)])
      sum[c] += part.coefficient * field(part.of.node, part.of.component);
  return sum;
}

void Mobility::add(Index node, const Vec3& impulse, NodeVectors& field) const {
  if (kind(node) == kFree) {
    field.row(node) += impulse.transpose();
    return;
  }
  for (int c = 0; c < 3; ++c)
    for (const Tie::Part& part : of(node).rows[static_cast<std::size_t>(c)])
      field(part.of.node, part.of.component) += part.coefficient * impulse[c];
}

Vec3 settle_motion(const Mobility& mobility, Index node, std::span<Grip> grips, Vec3& motion) {
  Vec3 sum = Vec3::Zero();
  for (int turn = 0; turn < kMostTurns; ++turn) {
    double largest = 0;
    for (Grip& grip : grips) {
      const Vec3 change = settle_one(mobility, node, grip, motion);
      sum += change;
      largest = std::max(largest, change.norm());
    }
    const bool is_exact = grips.size() == 1 && mobility.is_free(node);
    if (is_exact || largest <= kSettled * (motion.norm() + sum.norm())) break;
  }
  return sum;
}

}  // namespace deform
