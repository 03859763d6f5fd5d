#pragma once

#include <string>

#include "deform/plugin/declaration.h"

namespace deform {

/// The type of a value in words: "number", "[x, y, z]", "normal plugin".
std::string type_text(const ParameterValue& value);

/// What a field's value must be, for messages: "number >= 0 [1/m]".
std::string expectation(const ParameterField& field);

/// What each component of a field's value must be, of a type ("number", "whole number") and in the
/// field's range.
std::string expectation(const ParameterField& field, const std::string& type);

}  // namespace deform
