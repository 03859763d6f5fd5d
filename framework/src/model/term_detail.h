/// How much of a state's geometry an energy term on jets reads.
#pragma once

#include "deform/model/energy_term.h"

namespace deform {

/// What a term may read of a state's geometry: a potential that is said to depend on r_1 and r_2
/// alone, what follows from these; any other, everything.
[[nodiscard]] Geometry::Detail detail_of(const JetTerm& term, const TermTraits& traits);

}  // namespace deform
