#pragma once

#include <filesystem>
#include <string_view>

#include "json/json.h"

namespace deform {

/// What a text holds; discarded where it is no JSON. What nests deeper than a scene may is none
/// either: whoever walks through it does so by recursion.
[[nodiscard]] Json parse_json(std::string_view text);

/// The object that a file of a run or comparison directory holds; null where there is no file, or
/// something else in it. Throws Error when it cannot be read, as read_file does.
[[nodiscard]] Json read_json_object(const std::filesystem::path& file);

}  // namespace deform
