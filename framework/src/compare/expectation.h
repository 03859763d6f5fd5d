/// Expectation files: claims on a comparison's figures that a program can check.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "deform/compare/comparison.h"

namespace deform {

/// The claims of a file, {"claims": ["gauss.flatness < terzopoulos.flatness", …]}: formulas over
/// figures (RUN.FIGURE) and numbers with + - * / ^, abs(), min(), max(), comparisons, && and ||.
/// Throws InputError with every problem: a file that is not of this form, a claim that is no
/// formula, a run or figure that the plan will not have.
[[nodiscard]] std::vector<std::string> read_claims(const std::filesystem::path& file,
                                                   const ComparisonPlan& plan);

/// Looks at each claim. One that names a figure which is not there does not hold; nor does one on
/// differences from a reference that another run has stood in for.
[[nodiscard]] std::vector<Claim> check_claims(const std::vector<std::string>& claims,
                                              const Comparison& comparison);

}  // namespace deform
