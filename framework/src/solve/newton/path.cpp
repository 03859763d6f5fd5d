#include "deform/solve/path.h"

#include <optional>
#include <vector>

#include "deform/solve/system.h"

#include "profile/profile.h"
#include "solve/newton/rotation_strain_step.h"
#include "solve/system_parts.h"

namespace deform {
namespace {

/// Directions that rotate no part of the surface by more than this go straight [rad].
constexpr double kStraight = 1e-3;

}  // namespace

struct Path::Impl {
  SystemParts* parts;
  NodeVectors from, direction;
  double angle = 0, length = 0;
  std::optional<RotationStrainStep> rotations;  // made when first needed
};

Path::Path(const System& system) : impl_(std::make_unique<Impl>()) {
  impl_->parts = &SystemParts::of(system);
}
Path::~Path() = default;

void Path::begin(const NodeVectors& r, const NodeVectors& d, bool rotates) {
  Impl& i = *impl_;
  i.from = r;
  i.direction = d;
  i.length = d.rowwise().norm().maxCoeff();
  i.angle = 0;
  if (!rotates) return;
  i.parts->meter.require_going_on();
  const Span span("rotation-strain direction");
  if (!i.rotations)
    i.rotations.emplace(*i.parts->model.surface, i.parts->model.rest, i.parts->constraints.map(),
                        std::vector<Freedom>{}, i.parts->solvers);
  i.angle = i.rotations->begin(r, d);
}

double Path::angle() const { return impl_->angle; }
bool Path::is_straight() const { return !(impl_->angle > kStraight); }
double Path::length() const { return impl_->length; }
const NodeVectors& Path::from() const { return impl_->from; }
const NodeVectors& Path::direction() const { return impl_->direction; }

void Path::at(double s, NodeVectors& r) const {
  if (is_straight())
    r = impl_->from + s * impl_->direction;
  else
    impl_->rotations->at(s, r);
}

}  // namespace deform
