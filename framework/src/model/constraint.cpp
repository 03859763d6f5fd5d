#include "deform/model/constraint.h"

namespace deform {

Constraint::~Constraint() = default;

}  // namespace deform
