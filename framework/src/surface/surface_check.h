#pragma once

#include <string>

#include "deform/surface/surface.h"

namespace deform {

/// Throws PluginFailure when what a surface says of itself does not fit together: sizes of its
/// arrays, numbers of nodes, values that are not finite; with all that was found. `origin`: the
/// plugin and its file.
void check_surface(const Surface& surface, const std::string& origin);

}  // namespace deform
