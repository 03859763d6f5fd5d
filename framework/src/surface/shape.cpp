#include "deform/surface/shape.h"

namespace deform {

Shape::~Shape() = default;

}  // namespace deform
