#pragma once

#include <string>
#include <vector>

#include "deform/compare/plan.h"

namespace deform {

/// What a grid calls its values: "normal=gauss", "xi=1e-6"; unique within each variation, and each
/// variation by as little of its pointer as tells it from the others. Letters, digits and _-+=.
[[nodiscard]] std::vector<std::vector<std::string>> value_labels(
    const std::vector<Variation>& variations);

}  // namespace deform
