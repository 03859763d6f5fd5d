#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "json/json.h"

namespace deform {

/// The keys and indices of a JSON pointer (RFC 6901); nothing if it is not one.
std::optional<std::vector<std::string>> pointer_steps(std::string_view pointer);

/// The pointer of a member or item of what `pointer` points to.
std::string child_pointer(const std::string& pointer, std::string_view key);
std::string child_pointer(const std::string& pointer, std::size_t index);

/// The pointer without its last step; "" has none and stays.
std::string parent_pointer(const std::string& pointer);

/// Whether `pointer` is `ancestor` or points to something within it.
bool is_within(std::string_view pointer, std::string_view ancestor);

/// Puts a value at a pointer: in place of what is there, as a new member of an object, or, where
/// the last step is "-", behind the last item of an array. Returns "" or why the pointer leads
/// nowhere. On the way, an object that the scene leaves to its defaults, or abbreviates to a
/// plugin's name, is written out first; `completed` gives the scene with all defaults, and is
/// called only for that.
std::string replace_at(Json& scene, const std::string& pointer, const Json& value,
                       const std::function<Json()>& completed);

/// Where a value is that was put at a pointer: the number of the item in place of "-".
std::string pointer_of_put(const Json& scene, const std::string& pointer);

}  // namespace deform
