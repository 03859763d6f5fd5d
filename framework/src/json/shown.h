#pragma once

#include <string>

#include "json/json.h"

namespace deform {

/// A JSON value on one line, cut where it is long: for messages. Always UTF-8.
std::string shown(const Json& json);

}  // namespace deform
