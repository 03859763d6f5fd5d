#pragma once

#include <string>

#include "deform/plugin/values.h"

#include "scene/json.h"

namespace deform {

/// A parameter's value as a scene says it. Null where no scene can say it: an empty selection, a
/// plugin without a name, a number that is NaN or −infinity.
Json to_json(const ParameterValue& value);

/// A JSON value on one line, cut where it is long: for messages. Always UTF-8.
std::string shown(const Json& json);

}  // namespace deform
