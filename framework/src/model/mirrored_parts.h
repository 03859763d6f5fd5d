/// Force fields, constraints and colliders of a world that is reflected at z = 0.
///
/// Each of these acts as the part that it is made of would in its own world: what comes in is
/// reflected, the part is asked, and what comes out is reflected back. Positions, velocities and
/// forces change the sign of z; unit normals of the surface, which are pseudovectors, those of x
/// and y. All of it is exact: a mirrored run has the bits of the run.
#pragma once

#include <memory>

#include "deform/model/collider.h"
#include "deform/model/constraint.h"
#include "deform/model/force_field.h"
#include "deform/types.h"

namespace deform {

/// `nodes`: of the surface. A field that reads its neighbours costs a copy of all nodes' z a block.
[[nodiscard]] std::shared_ptr<ForceField> mirrored(std::shared_ptr<ForceField> field, Index nodes);
[[nodiscard]] std::shared_ptr<Constraint> mirrored(std::shared_ptr<Constraint> constraint);
[[nodiscard]] std::shared_ptr<Collider> mirrored(std::shared_ptr<Collider> collider);

}  // namespace deform
