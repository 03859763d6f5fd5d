/// Expectation files: claims on a comparison's figures that a program can check.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "deform/compare/comparison.h"

namespace deform {

/// The claims of a file, {"claims": ["gauss.flatness < terzopoulos.flatness", …]}: formulas over
/// figures (RUN.FIGURE) and numbers with + - * / ^, abs(), min(), max(), comparisons, && and ||.
/// `runs` are the names that there will be. Throws InputError with every problem: a file that is
/// not of this form, a claim that is no formula, a run or figure that there cannot be.
[[nodiscard]] std::vector<std::string> read_claims(const std::filesystem::path& file,
                                                   const std::vector<std::string>& runs);

/// Looks at each claim. One that names a figure which is not there does not hold.
[[nodiscard]] std::vector<Claim> check_claims(const std::vector<std::string>& claims,
                                              const std::vector<RunComparison>& runs);

}  // namespace deform
