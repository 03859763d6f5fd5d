#include "deform/version.h"

namespace deform {

const char* version() { return DEFORM_VERSION; }

}  // namespace deform
