#include "solve/external_forces.h"

#include <algorithm>

#include "parallel/parallel.h"
#include "plugin/guard.h"

namespace deform {
namespace {

/// Reflection at z = 0.
void reflect(const NodeVectors& from, NodeVectors& to) {
  to = from;
  to.col(2) *= -1;
}

}  // namespace

ExternalForces::ExternalForces(const ModelParts& parts)
    : forces_(parts.forces),
      areas_(parts.surface->areas()),
      mass_(parts.mass),
      mirrored_(parts.mirrored) {
  for (const auto& f : forces_) needs_normals_ = needs_normals_ || f.object->traits().normals;
}

/// Calls visit(force field, block of nodes) for all of both, blocks in parallel.
template <class Visit>
void ExternalForces::visit_blocks(const State& state, const NodeVectors& normals,
                                  const Visit& visit) {
  const NodeVectors *r = &state.r, *v = &state.v, *n = &normals;
  if (mirrored_) {
    reflect(state.r, r_);
    reflect(state.v, v_);
    reflect(normals, n_);
    n_ *= -1;  // a normal is a pseudovector: the reflected surface's is the negative reflection
    r = &r_, v = &v_, n = &n_;
  }
  parallel_blocks(state.r.rows(), kBlock, [&](Index first, Index size) {
    NodeBlock block{.first = first,
                    .size = size,
                    .time = state.time,
                    .r = rows_from(*r, first),
                    .v = rows_from(*v, first),
                    .normal = needs_normals_ ? rows_from(*n, first) : ConstVectors{},
                    .area = {areas_.data() + first, static_cast<std::size_t>(size)},
                    .mass = {mass_.data() + first, static_cast<std::size_t>(size)}};
    for (const auto& field : forces_)
      guarded(field.origin, "computing its force", [&] { visit(*field.object, block); });
  });
}

void ExternalForces::add_force(const State& state, const NodeVectors& normals, NodeVectors& f) {
  if (forces_.empty()) return;
  if (mirrored_) f_.setZero(f.rows(), 3);
  NodeVectors& sum = mirrored_ ? f_ : f;
  visit_blocks(state, normals, [&](const ForceField& field, const NodeBlock& block) {
    field.add_force(block, rows_from(sum, block.first));
  });
  if (mirrored_) {
    f_.col(2) *= -1;
    f += f_;
  }
}

void ExternalForces::add_tangent(const State& state, const NodeVectors& normals,
                                 NodeValues& stiffness, NodeValues& damping) {
  visit_blocks(state, normals, [&](const ForceField& field, const NodeBlock& block) {
    if (!field.traits().isotropic_tangent) return;
    const auto size = static_cast<std::size_t>(block.size);
    field.add_tangent(block, {stiffness.data() + block.first, size},
                      {damping.data() + block.first, size});
  });
}

double ExternalForces::potential(const State& state, const NodeVectors& normals) {
  NodeValues energy = NodeValues::Zero(state.r.rows());
  visit_blocks(state, normals, [&](const ForceField& field, const NodeBlock& block) {
    if (field.traits().potential)
      field.add_potential(block,
                          {energy.data() + block.first, static_cast<std::size_t>(block.size)});
  });
  double sum = 0;
  for (const double e : energy) sum += e;
  return sum;
}

}  // namespace deform
