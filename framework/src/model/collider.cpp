#include "deform/model/collider.h"

namespace deform {

Collider::~Collider() = default;

bool Collider::carry(double /*from*/, double /*to*/, Index /*size*/, ConstVectors /*points*/,
                     Vectors /*carried*/) const {
  return false;
}

}  // namespace deform
