#pragma once

#include "deform/plugin/values.h"

#include "json/json.h"

namespace deform {

/// A parameter's value as a scene says it. Null where no scene can say it: an empty selection, a
/// plugin without a name, a number that is NaN or −infinity.
Json to_json(const ParameterValue& value);

}  // namespace deform
