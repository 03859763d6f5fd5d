#pragma once

#include <nlohmann/json.hpp>

namespace deform {

/// The JSON value used for scenes. The ordered kind keeps object members in the order of the file,
/// so that a completed scene is written back the way its author laid it out.
using Json = nlohmann::ordered_json;

}  // namespace deform
