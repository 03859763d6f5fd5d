#include "deform/plugin/registry.h"

#include "json/json_schema.h"
#include "plugin/field_schema.h"

namespace deform {
namespace {

/// Some plugin of a kind: which there are is for the schema of scenes to say.
Json any_plugin(PluginKind /*kind*/) {
  const Json object{{"type", "object"},
                    {"required", Json::array({kPluginKey})},
                    {"properties", Json{{kPluginKey, Json{{"type", "string"}}}}}};
  Json schema = Json::object();
  schema["anyOf"] = Json::array({Json{{"type", "string"}}, object});
  return schema;
}

}  // namespace

std::string parameter_schema(const LoadedPlugin& plugin) {
  Json schema{{"$schema", kJsonSchemaDraft}};
  schema.update(plugin_object_schema(plugin, any_plugin));
  return schema_text(schema);
}

}  // namespace deform
