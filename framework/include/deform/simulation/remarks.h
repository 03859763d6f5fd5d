/// What a user may not have meant, though it is no error.
#pragma once

#include <vector>

#include "deform/export.h"
#include "deform/simulation/scene.h"

namespace deform {

/// Each with its place in front, as the problems of a scene have it. `run` and `compare` warn of
/// them.
[[nodiscard]] DEFORM_API std::vector<Problem> remarks(const Scene& scene);

}  // namespace deform
