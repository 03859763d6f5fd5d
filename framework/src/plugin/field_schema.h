#pragma once

#include <functional>
#include <vector>

#include "deform/plugin/registry.h"

#include "json/json.h"

namespace deform {

/// The key of a plugin's object in a scene that says which it is.
inline constexpr const char* kPluginKey = "plugin";

/// JSON Schema of what may stand where a scene names a plugin of a kind.
using PluginSchema = std::function<Json(PluginKind)>;

/// JSON Schema of a field's values, with its description and default.
Json field_schema(const ParameterField& field, const PluginSchema& plugin_schema);

/// JSON Schema of an object with all of these fields and no others.
Json fields_schema(const std::vector<const ParameterFields*>& parts,
                   const PluginSchema& plugin_schema);

/// JSON Schema of a plugin's object in a scene: its name, the common fields of its kind, its own.
Json plugin_object_schema(const LoadedPlugin& plugin, const PluginSchema& plugin_schema);

}  // namespace deform
