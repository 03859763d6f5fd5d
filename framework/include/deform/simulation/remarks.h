/// What a user may not have meant, though it is no error.
#pragma once

#include <set>
#include <string>
#include <vector>

#include "deform/export.h"
#include "deform/simulation/scene.h"

namespace deform {

/// Each with its place in front, as the problems of a scene have it. `run` warns of them.
[[nodiscard]] DEFORM_API std::vector<Problem> remarks(const Scene& scene);
/// The same, of several variants one after another: without what was `said` of another one, and
/// adds what is new to that.
[[nodiscard]] DEFORM_API std::vector<Problem> new_remarks(const Scene& scene,
                                                          std::set<std::string>& said);

}  // namespace deform
