#pragma once

#include "scene/plain_reader.h"

namespace deform {

/// Reads a selection of nodes, one selector or a list of them: {"centre": [a1, a2], "radius": x},
/// {"box": [[a1, a2], [b1, b2]]}, {"boundary": name or names}, {"corners": name or names}, {"node":
/// number or numbers}. Which names and numbers there are is for the surface to say.
std::optional<NodeSelection> read_selection(const Json& json, const ValuePlace& place,
                                            PlainReader& reader);

}  // namespace deform
