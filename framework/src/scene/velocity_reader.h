#pragma once

#include <optional>

#include "deform/simulation/scene.h"

#include "scene/plain_reader.h"

namespace deform {

/// Members of a scene's `velocity`, and what their fields are called.
inline constexpr const char* kLinear = "linear";
inline constexpr const char* kSpin = "spin";
inline constexpr const char* kAbout = "about";

/// Reads the velocities at first: [vx, vy, vz], each a number or a formula, or an object with the
/// fields `linear` (the same), `spin` and `about`. Writes the defaults of what is missing into an
/// object, but not `about`: its default no scene can say.
std::optional<InitialVelocity> read_velocity(Json& json, const ParameterFields& fields,
                                             const std::string& pointer, PlainReader& reader);

/// JSON Schema of what `read_velocity` reads, but for what formulas mean.
Json velocity_schema(const ParameterFields& fields);
/// Of one of its members.
Json velocity_member_schema(const ParameterField& field);

}  // namespace deform
