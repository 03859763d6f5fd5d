#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace deform {

/// The valid name that a wrong one was most likely meant to be; nothing if none is near. Near is
/// at most max(2, length / 3) edits away (insert, delete, replace, swap two neighbours; upper and
/// lower case of ASCII letters are the same), and with something left in common. Of equally near
/// names the first one is returned.
std::optional<std::string> nearest_name(std::string_view wrong, std::span<const std::string> valid);

/// An ending for a message on a wrong name: `; did you mean "gauss"?`. If no valid name is near and
/// there are at most 12 of them, `; valid are "gauss", "wave"`. Otherwise empty.
std::string did_you_mean(std::string_view wrong, std::span<const std::string> valid);

}  // namespace deform
