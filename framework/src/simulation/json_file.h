#pragma once

#include <filesystem>

#include "scene/json.h"

namespace deform {

/// The object that a file of a run or comparison directory holds; null where there is no file, or
/// something else in it. Throws Error when it cannot be read.
[[nodiscard]] Json read_json_object(const std::filesystem::path& file);

}  // namespace deform
