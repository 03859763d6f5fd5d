/// What a user may not have meant, though it is no error.
#pragma once

#include <vector>

#include "deform/simulation/scene.h"

namespace deform::app {

/// Each with its place in front, as the problems of a scene have it.
[[nodiscard]] std::vector<Problem> remarks(const Scene& scene);

}  // namespace deform::app
