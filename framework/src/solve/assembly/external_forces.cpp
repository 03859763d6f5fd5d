#include "solve/assembly/external_forces.h"

#include <algorithm>
#include <string>

#include "deform/parallel.h"

#include "plugin/guard.h"

namespace deform {

ExternalForces::ExternalForces(const ModelParts& parts)
    : forces_(parts.forces), areas_(parts.areas), mass_(parts.mass) {
  for (const auto& f : forces_) {
    traits_.push_back(guarded(f.origin, "saying what it is", [&] { return f.object->traits(); }));
    needs_normals_ = needs_normals_ || traits_.back().normals;
    needs_neighbours_ = needs_neighbours_ || traits_.back().neighbours;
    auto& pairs = pairs_.emplace_back();
    if (!traits_.back().exact_tangent && !traits_.back().exact_damping) continue;
    pairs = guarded(f.origin, "naming the nodes of its tangent",
                    [&] { return f.object->tangent_pairs(); });
    for (const auto& [a, b] : pairs)
      if (a < 0 || b < a || b >= areas_.size())
        throw PluginFailure("plugin " + f.origin + " links nodes " + std::to_string(a) + " and " +
                            std::to_string(b) + ", expected 0 ≤ a ≤ b ≤ " +
                            std::to_string(areas_.size() - 1));
  }
}

NodeBlock ExternalForces::block_of(const State& state, const NodeVectors& normals, Index first,
                                   Index size) const {
  return {.first = first,
          .size = size,
          .time = state.time,
          .r = rows_from(state.r, first),
          .v = rows_from(state.v, first),
          .normal = needs_normals_ ? rows_from(normals, first) : ConstVectors{},
          .area = {areas_.data() + first, static_cast<std::size_t>(size)},
          .mass = {mass_.data() + first, static_cast<std::size_t>(size)},
          .all_r = needs_neighbours_ ? rows_from(state.r, 0) : ConstVectors{},
          .all_v = needs_neighbours_ ? rows_from(state.v, 0) : ConstVectors{}};
}

/// Calls visit(force field, block of nodes) for all of both, or of one field, blocks in parallel.
template <class Visit>
void ExternalForces::visit_blocks(const State& state, const NodeVectors& normals,
                                  const Named<ForceField>* only, const Visit& visit) {
  parallel_blocks(areas_.size(), kBlock, [&](Index first, Index size) {
    const NodeBlock block = block_of(state, normals, first, size);
    for (std::size_t i = 0; i < forces_.size(); ++i)
      if (only == nullptr || only == &forces_[i])
        guarded(forces_[i].origin, "computing its force",
                [&] { visit(*forces_[i].object, traits_[i], block); });
  });
}

void ExternalForces::add_force(const State& state, const NodeVectors& normals, NodeVectors& f,
                               const Named<ForceField>* only) {
  if (forces_.empty()) return;
  visit_blocks(state, normals, only,
               [&](const ForceField& field, const ForceTraits&, const NodeBlock& block) {
                 field.add_force(block, rows_from(f, block.first));
               });
}

void ExternalForces::add_tangent(const State& state, const NodeVectors& normals,
                                 NodeValues& stiffness, NodeValues& damping,
                                 const Named<ForceField>* only, bool spares_exact) {
  visit_blocks(state, normals, only,
               [&](const ForceField& field, const ForceTraits& traits, const NodeBlock& block) {
                 if (!traits.isotropic_tangent && !traits.damping_bound) return;
                 if (spares_exact && traits.exact_damping) return;
                 const auto size = static_cast<std::size_t>(block.size);
                 field.add_tangent(block, {stiffness.data() + block.first, size},
                                   {damping.data() + block.first, size});
               });
}

bool ExternalForces::add_conservative_stiffness(const State& state, const NodeVectors& normals,
                                                BlockMatrix& k, NodeVectors& f) {
  NodeValues stiffness = NodeValues::Zero(k.nodes), damping = stiffness;
  bool any = false;
  for (std::size_t i = 0; i < forces_.size(); ++i) {
    const ForceTraits& t = traits_[i];
    if (!t.potential || !(t.isotropic_tangent || t.exact_tangent)) continue;
    any = true;
    add_force(state, normals, f, &forces_[i]);
    add_tangent(state, normals, stiffness, damping, &forces_[i], true);
    add_exact_tangent(state, normals, 0, k, &forces_[i]);
  }
  for (Index a = 0; any && a < k.nodes; ++a) k.block(a, a).diagonal().array() += stiffness[a];
  return any;
}

void ExternalForces::add_exact_tangent(const State& state, const NodeVectors& normals, double rate,
                                       BlockMatrix& k, const Named<ForceField>* only) {
  const NodeBlock nodes = block_of(state, normals, 0, areas_.size());
  const Eigen::Matrix3d zero = Eigen::Matrix3d::Zero();
  for (std::size_t i = 0; i < forces_.size(); ++i) {
    if (only != nullptr && only != &forces_[i]) continue;
    const bool damps = traits_[i].exact_damping && rate != 0;
    if (!traits_[i].exact_tangent && !damps) continue;
    blocks_.assign(pairs_[i].size(), zero);
    damping_blocks_.assign(damps ? pairs_[i].size() : 0, zero);
    guarded(forces_[i].origin, "computing its tangent", [&] {
      if (traits_[i].exact_tangent) forces_[i].object->add_exact_tangent(nodes, blocks_);
      if (damps) forces_[i].object->add_exact_damping(nodes, damping_blocks_);
    });
    for (std::size_t p = 0; p < pairs_[i].size(); ++p) {
      const auto& [a, b] = pairs_[i][p];
      Eigen::Matrix3d block = blocks_[p];
      if (damps) block += rate * damping_blocks_[p];
      if (a == b) block = (0.5 * (block + block.transpose())).eval();
      k.block(a, b) += block;
    }
  }
}

std::vector<std::string> ExternalForces::without_tangent() const {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < forces_.size(); ++i) {
    const ForceTraits& t = traits_[i];
    const bool follows = t.normals || t.neighbours;
    if (follows && !t.exact_tangent) names.push_back(forces_[i].name);
  }
  return names;
}

std::vector<std::string> ExternalForces::without_potential() const {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < forces_.size(); ++i)
    if (!traits_[i].potential) names.push_back(forces_[i].name);
  return names;
}

const NodeValues& ExternalForces::potential(const State& state, const NodeVectors& normals,
                                            const Named<ForceField>* only) {
  potential_.setZero(areas_.size());
  visit_blocks(state, normals, only,
               [&](const ForceField& field, const ForceTraits& traits, const NodeBlock& block) {
                 if (traits.potential)
                   field.add_potential(block, {potential_.data() + block.first,
                                               static_cast<std::size_t>(block.size)});
               });
  return potential_;
}

}  // namespace deform
