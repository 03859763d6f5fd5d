#include "model/mirrored_parts.h"

#include <algorithm>
#include <functional>
#include <iterator>
#include <span>
#include <utility>
#include <vector>

namespace deform {
namespace {

void negate(double* values, Index size) {
  std::transform(values, values + size, values, std::negate<>());
}

/// Off-diagonal entries that link z with x or y: R B R with R = diag(1, 1, −1).
void reflect(std::span<Eigen::Matrix3d> blocks) {
  for (Eigen::Matrix3d& block : blocks) {
    block.topRightCorner<2, 1>() *= -1;
    block.bottomLeftCorner<1, 2>() *= -1;
  }
}

/// Negated copies of component arrays; views of them are valid as long as it lives.
class NegatedCopies {
 public:
  /// `most`: numbers in all copies together.
  explicit NegatedCopies(Index most) { room_.reserve(static_cast<std::size_t>(most)); }

  const double* of(const double* values, Index size) {
    const auto first = static_cast<Index>(room_.size());
    std::transform(values, values + size, std::back_inserter(room_), std::negate<>());
    return room_.data() + first;
  }
  /// Nothing where there is nothing, or none is wanted.
  ConstVectors reflected(ConstVectors v, Index size) {
    if (!v || size == 0) return {};
    return {v.x, v.y, of(v.z, size)};
  }

 private:
  std::vector<double> room_;  // never grows: views stay valid
};

/// What a part does between steps and over time is the same in both worlds.
template <class Interface>
class Mirrored : public Interface {
 public:
  explicit Mirrored(std::shared_ptr<Interface> part) : part_(std::move(part)) {}

  void save(Memory& memory) const override { part_->save(memory); }
  void load(const Memory& memory) override { part_->load(memory); }
  [[nodiscard]] double longest_step(double time) const override {
    return part_->longest_step(time);
  }
  [[nodiscard]] double next_break(double after) const override { return part_->next_break(after); }

 protected:
  [[nodiscard]] const Interface& part() const { return *part_; }

 private:
  std::shared_ptr<Interface> part_;
};

/// Nodes as the field of the other world sees them.
class ReflectedNodes {
 public:
  /// `all`: how many of all nodes the field reads, if it reads others than the block's.
  ReflectedNodes(const NodeBlock& nodes, Index all)
      : copies_(4 * nodes.size + 2 * all), nodes_(nodes) {
    nodes_.r = copies_.reflected(nodes.r, nodes.size);
    nodes_.v = copies_.reflected(nodes.v, nodes.size);
    nodes_.all_r = copies_.reflected(nodes.all_r, all);
    nodes_.all_v = copies_.reflected(nodes.all_v, all);
    if (!nodes.normal) return;
    nodes_.normal.x = copies_.of(nodes.normal.x, nodes.size);
    nodes_.normal.y = copies_.of(nodes.normal.y, nodes.size);
  }
  [[nodiscard]] const NodeBlock& block() const { return nodes_; }

 private:
  NegatedCopies copies_;
  NodeBlock nodes_;
};

class MirroredField final : public Mirrored<ForceField> {
 public:
  MirroredField(std::shared_ptr<ForceField> field, Index nodes)
      : Mirrored(std::move(field)), nodes_(nodes) {}

  [[nodiscard]] ForceTraits traits() const override { return part().traits(); }
  [[nodiscard]] std::vector<std::pair<Index, Index>> tangent_pairs() const override {
    return part().tangent_pairs();
  }
  void add_force(const NodeBlock& nodes, Vectors force) const override {
    // With what is there already: the sums are then those of the run, bit by bit.
    negate(force.z, nodes.size);
    part().add_force(reflected(nodes).block(), force);
    negate(force.z, nodes.size);
  }
  void add_tangent(const NodeBlock& nodes, Values stiffness, Values damping) const override {
    part().add_tangent(reflected(nodes).block(), stiffness, damping);
  }
  void add_exact_tangent(const NodeBlock& nodes, std::span<Eigen::Matrix3d> blocks) const override {
    reflect(blocks);
    part().add_exact_tangent(reflected(nodes).block(), blocks);
    reflect(blocks);
  }
  void add_exact_damping(const NodeBlock& nodes, std::span<Eigen::Matrix3d> blocks) const override {
    reflect(blocks);
    part().add_exact_damping(reflected(nodes).block(), blocks);
    reflect(blocks);
  }
  void add_potential(const NodeBlock& nodes, Values energy) const override {
    part().add_potential(reflected(nodes).block(), energy);
  }

 private:
  [[nodiscard]] ReflectedNodes reflected(const NodeBlock& nodes) const {
    return {nodes, part().traits().neighbours ? nodes_ : 0};
  }

  Index nodes_;
};

class MirroredConstraint final : public Mirrored<Constraint> {
 public:
  using Mirrored::Mirrored;

  void reduce(Reduction& reduction) const override {
    reduction.reflect();
    part().reduce(reduction);
    reduction.reflect();
  }
  void prescribe(double time, NodeVectors& r) const override {
    r.col(2) *= -1;
    part().prescribe(time, r);
    r.col(2) *= -1;
  }
};

class MirroredCollider final : public Mirrored<Collider> {
 public:
  using Mirrored::Mirrored;

  [[nodiscard]] bool is_convex() const override { return part().is_convex(); }
  void measure(double time, ConstVectors points, Values distance, Vectors normal) const override {
    const auto size = static_cast<Index>(distance.size());
    NegatedCopies copies(size);
    part().measure(time, copies.reflected(points, size), distance, normal);
    negate(normal.z, size);
  }
  [[nodiscard]] bool carry(double from, double to, Index size, ConstVectors points,
                           Vectors carried) const override {
    NegatedCopies copies(size);
    if (!part().carry(from, to, size, copies.reflected(points, size), carried)) return false;
    negate(carried.z, size);
    return true;
  }
};

}  // namespace

std::shared_ptr<ForceField> mirrored(std::shared_ptr<ForceField> field, Index nodes) {
  return std::make_shared<MirroredField>(std::move(field), nodes);
}

std::shared_ptr<Constraint> mirrored(std::shared_ptr<Constraint> constraint) {
  return std::make_shared<MirroredConstraint>(std::move(constraint));
}

std::shared_ptr<Collider> mirrored(std::shared_ptr<Collider> collider) {
  return std::make_shared<MirroredCollider>(std::move(collider));
}

}  // namespace deform
