#pragma once

#include <string>
#include <vector>

#include "deform/compare/comparison.h"

namespace deform::app {

/// The table of a comparison for print_table, a row a run in their order: as many columns as
/// `width` characters hold, those that tell runs apart first.
[[nodiscard]] std::vector<std::vector<std::string>> comparison_table(const Comparison& comparison,
                                                                     std::size_t width);

}  // namespace deform::app
