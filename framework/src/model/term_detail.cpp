#include "model/term_detail.h"

#include <algorithm>

namespace deform {

Geometry::Detail detail_of(const JetTerm& term, const TermTraits& traits) {
  const auto is_first = [](Derivative d) { return slot(d) <= slot(Derivative::d2); };
  const bool reads_first_alone = traits.potential && !traits.strong_form &&
                                 term.normal() == nullptr && term.auxiliary_fields() == 0 &&
                                 std::ranges::all_of(term.dependence(), is_first);
  return reads_first_alone ? Geometry::Detail::first : Geometry::Detail::second;
}

}  // namespace deform
