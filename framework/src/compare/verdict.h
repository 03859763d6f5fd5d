/// What a comparison says in the end: a table and sentences.
#pragma once

#include <string>
#include <vector>

#include "deform/compare/comparison.h"

#include "json/json.h"

namespace deform {

/// The sentences, the headline first (docs/report-format.md).
[[nodiscard]] std::vector<std::string> sentences_of(const Comparison& comparison);

/// The table and the sentences as the report's data has them.
[[nodiscard]] Json verdict_json(const Comparison& comparison);

/// "1.2 mm": three digits and a prefix; "0 m".
[[nodiscard]] std::string length_text(double metres);

}  // namespace deform
