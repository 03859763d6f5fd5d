/// The version of the framework.
#pragma once

#include "deform/export.h"

namespace deform {

/// Of the library that is loaded, "major.minor.patch".
[[nodiscard]] DEFORM_API const char* version();

}  // namespace deform
