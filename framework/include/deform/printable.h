/// Texts of others on their way to a terminal or a log.
#pragma once

#include <string>
#include <string_view>

#include "deform/export.h"

namespace deform {

/// The text on one line, with nothing in it that a terminal takes for an order or that shows
/// otherwise than it is written: control characters (C0, DEL, C1), line and paragraph separators
/// and those that are not seen or turn the direction of writing (Unicode Standard Annex 9; Boucher
/// & Anderson 2021) become \n, \t, \u001b or \u202e; bytes that are no UTF-8 become \x9b. Anything
/// else stays, so that a text without such characters is what it was.
[[nodiscard]] DEFORM_API std::string printable(std::string_view text);

}  // namespace deform
