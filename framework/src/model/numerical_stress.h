#pragma once

#include "deform/model/energy_term.h"

namespace deform {

/// Whether a term leaves its stress to the numerical derivative of its energy; asks it for the
/// stress of a block to find out.
[[nodiscard]] bool has_numerical_stress(const JetTerm& term, const SampleBlock& block);

}  // namespace deform
