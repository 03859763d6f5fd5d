#pragma once

#include <string>

#include <nlohmann/json.hpp>

namespace deform {

/// The JSON value used for scenes. The ordered kind keeps object members in the order of the file,
/// so that a completed scene is written back the way its author laid it out.
using Json = nlohmann::ordered_json;

/// Whether JSON can hold the text: names of files need not be UTF-8.
[[nodiscard]] inline bool is_utf8(const std::string& text) {
  try {
    (void)Json(text).dump();
    return true;
  } catch (const Json::type_error&) {
    return false;
  }
}

}  // namespace deform
