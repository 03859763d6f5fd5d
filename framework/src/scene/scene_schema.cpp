#include <set>
#include <utility>

#include "deform/log.h"
#include "deform/simulation/scene.h"

#include "json/json_schema.h"
#include "plugin/field_schema.h"
#include "scene/scene_rules.h"
#include "scene/velocity_reader.h"

namespace deform {
namespace {

using Form = SceneSection::Form;

/// Names of variants become names of folders and columns.
constexpr const char* kVariantName = "^(?!base$)[0-9A-Za-z_+=][-0-9A-Za-z_+=.]*$";
/// A JSON pointer to a value of the scene that a variant may replace.
constexpr const char* kVariantPointer = "^(?!/variants(/|$))(/([^~/]|~[01])*)+$";

Json reference(const std::string& name) { return Json{{"$ref", "#/$defs/" + name}}; }
Json kind_reference(PluginKind kind) { return reference(std::string(name_of(kind))); }

std::string definition_name(const LoadedPlugin& plugin) {
  return std::string(name_of(plugin.file().kind)) + '-' + plugin.file().name;
}

std::vector<const LoadedPlugin*> loaded_plugins(const PluginRegistry& registry, PluginKind kind) {
  std::vector<const LoadedPlugin*> plugins;
  for (const std::string& name : registry.names(kind)) {
    try {
      plugins.push_back(&registry.load(kind, name));
    } catch (const InputError& error) {
      log::warn("plugin " + std::string(name_of(kind)) + '/' + name +
                " is left out: " + error.what());
    }
  }
  return plugins;
}

/// A plugin whose name alone is enough.
bool has_short_form(const LoadedPlugin& plugin) {
  for (const auto* fields : {&common_fields(plugin.file().kind), &plugin.fields()}) {
    for (const ParameterField& field : *fields) {
      if (field.required) return false;
    }
  }
  return true;
}

/// A list of names, with what each one means for editors that show it.
Json names_schema(const std::vector<const LoadedPlugin*>& plugins) {
  Json schema{{"enum", Json::array()}, {"enumDescriptions", Json::array()}};
  for (const LoadedPlugin* plugin : plugins) {
    schema["enum"].push_back(plugin->file().name);
    schema["enumDescriptions"].push_back(plugin->descriptor().text.summary);
  }
  return schema;
}

/// The plugins of a kind: by name alone or as an object. Conditions rather than alternatives, so
/// that an editor or a validator looks at the plugin that is named, and speaks of that one alone.
Json kind_schema(PluginKind kind, const std::vector<const LoadedPlugin*>& plugins) {
  Json object{{"type", "object"},
              {"required", Json::array({kPluginKey})},
              {"properties", Json{{kPluginKey, names_schema(plugins)}}}};
  for (const LoadedPlugin* plugin : plugins) {
    const Json is_this{{kPluginKey, Json{{"const", plugin->file().name}}}};
    object["allOf"].push_back(Json{{"if", Json{{"type", "object"},
                                               {"required", Json::array({kPluginKey})},
                                               {"properties", is_this}}},
                                   {"then", reference(definition_name(*plugin))}});
  }
  Json schema{{"title", std::string(name_of(kind)) + " plugin"}};
  std::vector<const LoadedPlugin*> nameable = plugins;
  std::erase_if(nameable, [](const LoadedPlugin* plugin) { return !has_short_form(*plugin); });
  if (nameable.empty()) {
    schema.update(object);
  } else {
    schema["if"] = Json{{"type", "string"}};
    schema["then"] = names_schema(nameable);
    schema["else"] = object;
  }
  return schema;
}

Json section_schema(const SceneSection& section) {
  switch (section.form) {
    case Form::value:
      return field_schema(section.fields().front(), kind_reference);
    case Form::object:
      return fields_schema({&section.fields()}, kind_reference);
    case Form::velocity:
      return velocity_schema(section.fields());
    case Form::plugin:
      return kind_reference(section.kind);
    case Form::plugins:
    case Form::shadows:
      return Json{
          {"type", "array"}, {"maxItems", kMostPlugins}, {"items", kind_reference(section.kind)}};
    case Form::note:
      return Json{{"type", "string"}};
    case Form::variants:
      return reference("variants");
  }
  return false;
}

/// What variants put at the keys of the scene is checked, what lies deeper is not: a pointer says
/// not which plugin it leads into.
Json changes_schema() {
  Json changes{{"type", "object"},
               {"propertyNames", Json{{"pattern", kVariantPointer}}},
               {"properties", Json::object()},
               {"patternProperties", Json::object()}};
  for (const SceneSection& section : scene_sections()) {
    if (section.form == Form::variants) continue;
    const std::string pointer = section.pointer();
    changes["properties"][pointer] = section_schema(section);
    if (section.form == Form::plugins || section.form == Form::shadows) {
      changes["patternProperties"]["^" + pointer + "/([0-9]+|-)$"] = kind_reference(section.kind);
    }
    if (section.form != Form::object && section.form != Form::velocity) continue;
    for (const ParameterField& field : section.fields()) {
      changes["properties"][pointer + '/' + field.name] = section.form == Form::object
                                                              ? field_schema(field, kind_reference)
                                                              : velocity_member_schema(field);
    }
  }
  return changes;
}

Json variants_schema() {
  return Json{
      {"description", "scenes made of this one: a name, JSON pointers, and the values there"},
      {"type", "object"},
      {"maxProperties", kMostVariants},
      {"propertyNames", Json{{"pattern", kVariantName}}},
      {"additionalProperties", changes_schema()}};
}

bool is_required(const SceneSection& section) {
  return section.required || (section.form == Form::value && section.fields().front().required);
}

}  // namespace

std::string scene_schema(const PluginRegistry& registry) {
  Json properties = Json::object(), required = Json::array(), definitions = Json::object();
  for (const SceneSection& section : scene_sections()) {
    properties[section.key()] = section_schema(section);
    if (is_required(section)) required.push_back(section.key());
  }
  definitions["variants"] = variants_schema();
  for (const PluginKind kind : kPluginKinds) {
    const auto plugins = loaded_plugins(registry, kind);
    definitions[std::string(name_of(kind))] = kind_schema(kind, plugins);
    for (const LoadedPlugin* plugin : plugins) {
      definitions[definition_name(*plugin)] = plugin_object_schema(*plugin, kind_reference);
    }
  }
  return schema_text(Json{{"$schema", kJsonSchemaDraft},
                          {"title", "deform scene"},
                          {"description", "what deform simulates; // comments are allowed"},
                          {"allowComments", true},
                          {"type", "object"},
                          {"required", required},
                          {"properties", properties},
                          {"additionalProperties", false},
                          {"$defs", definitions}});
}

}  // namespace deform
