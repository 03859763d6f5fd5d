#include "deform/model/collider.h"

namespace deform {

Collider::~Collider() = default;

}  // namespace deform
