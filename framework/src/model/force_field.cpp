#include "deform/model/force_field.h"

#include "deform/error.h"

namespace deform {

ForceField::~ForceField() = default;

// Without the trait there is nothing to add; with it, silence would be a wrong result.

void ForceField::add_tangent(const NodeBlock& /*nodes*/, Values /*stiffness*/,
                             Values /*damping*/) const {
  if (traits().isotropic_tangent || traits().damping_bound) {
    throw PluginFailure("a force field declares a tangent or a bound of it without add_tangent");
  }
}

std::vector<std::pair<Index, Index>> ForceField::tangent_pairs() const { return {}; }

void ForceField::add_exact_tangent(const NodeBlock& /*nodes*/,
                                   std::span<Eigen::Matrix3d> /*blocks*/) const {
  if (traits().exact_tangent) {
    throw PluginFailure("a force field declares an exact tangent without add_exact_tangent");
  }
}

void ForceField::add_exact_damping(const NodeBlock& /*nodes*/,
                                   std::span<Eigen::Matrix3d> /*blocks*/) const {
  if (traits().exact_damping) {
    throw PluginFailure("a force field declares an exact damping without add_exact_damping");
  }
}

void ForceField::add_potential(const NodeBlock& /*nodes*/, Values /*energy*/) const {
  if (traits().potential) {
    throw PluginFailure("a force field declares potential without add_potential");
  }
}

}  // namespace deform
