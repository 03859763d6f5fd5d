#pragma once

#include "scene/plain_reader.h"

namespace deform {

/// Reads a factor over time: a number, {"ramp": [t0, t1]}, {"pulse": [t0, t1]} or {"table": [[t,
/// factor], …]}, times in seconds and ascending.
std::optional<TimeProfile> read_profile(const Json& json, const ValuePlace& place,
                                        PlainReader& reader);

}  // namespace deform
