#include "plugin/field_schema.h"

#include <utility>

#include "plugin/value_json.h"

namespace deform {
namespace {

/// JSON Schema of the values of one field; one overload for each alternative of ParameterValue.
class FieldSchema {
 public:
  FieldSchema(const ParameterField& field, const PluginSchema& plugin_schema)
      : field_(field), plugin_schema_(plugin_schema) {}

  Json operator()(bool /*value*/) const { return boolean(); }
  Json operator()(std::int64_t /*value*/) const { return integer(); }
  Json operator()(double /*value*/) const { return number(); }
  Json operator()(const std::string& /*value*/) const { return text(); }
  Json operator()(const std::filesystem::path& /*value*/) const { return type("string"); }
  Json operator()(const Vec2& /*value*/) const { return list(number(), 2); }
  Json operator()(const Vec3& /*value*/) const { return list(number(), 3); }
  Json operator()(const PairWeights& /*value*/) const {
    return any_of({number(), list(list(number(), 2), 2)});
  }
  Json operator()(const PairWeightsField& /*value*/) const {
    Json choice = field();
    choice["anyOf"].push_back(list(list(field(), 2), 2));
    return choice;
  }
  Json operator()(const Field& /*value*/) const { return field(); }
  Json operator()(const NamedNumbers& /*value*/) const {
    Json schema = type("object");
    schema["additionalProperties"] = number();
    return schema;
  }
  Json operator()(const std::vector<double>& /*value*/) const { return list(number()); }
  Json operator()(const std::vector<std::int64_t>& /*value*/) const { return list(integer()); }
  Json operator()(const std::vector<bool>& /*value*/) const {
    return any_of({boolean(), list(boolean())});
  }
  Json operator()(const std::vector<std::string>& /*value*/) const { return list(text()); }
  Json operator()(const std::vector<Vec3>& /*value*/) const { return list(list(number(), 3)); }
  Json operator()(const std::array<std::int64_t, 2>& /*value*/) const { return list(integer(), 2); }
  Json operator()(const std::array<bool, 2>& /*value*/) const {
    return any_of({boolean(), list(boolean(), 2)});
  }
  Json operator()(const TimeProfile& /*value*/) const {
    const Json times = list(type("number"), 2);
    Json table = list(times);
    table["minItems"] = 1;
    return any_of({type("number"), object({{"ramp", times}}), object({{"pulse", times}}),
                   object({{"table", table}})});
  }
  Json operator()(const NodeSelection& /*value*/) const {
    Json several = list(selector());
    several["minItems"] = 1;
    return any_of({selector(), several});
  }
  Json operator()(const PluginUse& use) const { return plugin_schema_(use.kind); }

 private:
  using Members = std::vector<std::pair<std::string, Json>>;

  static Json type(const char* name) { return Json{{"type", name}}; }
  static Json boolean() { return type("boolean"); }

  static Json any_of(const std::vector<Json>& schemas) {
    Json choice = Json::object();
    choice["anyOf"] = schemas;
    return choice;
  }
  static Json list(const Json& items, int size = -1) {
    Json schema = type("array");
    schema["items"] = items;
    if (size >= 0) schema["minItems"] = schema["maxItems"] = size;
    return schema;
  }
  static Json object(const Members& members) {
    Json schema = type("object");
    schema["required"] = Json::array();
    schema["properties"] = Json::object();
    for (const auto& [name, member] : members) {
      schema["required"].push_back(name);
      schema["properties"][name] = member;
    }
    schema["additionalProperties"] = false;
    return schema;
  }
  static Json selector() {
    const Json point = list(type("number"), 2), place = list(type("number"), 3);
    Json radius = type("number");
    radius["minimum"] = 0;
    const auto one_or_several = [](const Json& one) {
      Json several = list(one);
      several["minItems"] = 1;
      return any_of({one, several});
    };
    const Json names = one_or_several(type("string"));
    Json node = type("integer");
    node["minimum"] = 0;
    return any_of({object({{"centre", point}, {"radius", radius}}),
                   object({{"box", list(point, 2)}}), object({{"boundary", names}}),
                   object({{"corners", names}}), object({{"node", one_or_several(node)}}),
                   object({{"sphere", place}, {"radius", radius}}),
                   object({{"space", list(place, 2)}}), object({{"nearest", place}})});
  }

  template <class Number>
  Json limited(const char* name) const {
    Json schema = type(name);
    const char* const lower = field_.minimum_excluded ? "exclusiveMinimum" : "minimum";
    if (field_.minimum) schema[lower] = static_cast<Number>(*field_.minimum);
    if (field_.maximum) schema["maximum"] = static_cast<Number>(*field_.maximum);
    return schema;
  }
  [[nodiscard]] Json integer() const { return limited<std::int64_t>("integer"); }
  [[nodiscard]] Json number() const {
    const Json finite = limited<double>("number");
    return field_.may_be_infinite ? any_of({finite, Json{{"const", "infinity"}}}) : finite;
  }
  [[nodiscard]] Json field() const {
    return any_of(
        {number(), object({{"formula", type("string")}}), object({{"map", type("string")}})});
  }
  [[nodiscard]] Json text() const {
    Json schema = type("string");
    if (!field_.choices.empty()) schema["enum"] = field_.choices;
    return schema;
  }

  const ParameterField& field_;
  const PluginSchema& plugin_schema_;
};

}  // namespace

Json field_schema(const ParameterField& field, const PluginSchema& plugin_schema) {
  Json schema = std::visit(FieldSchema(field, plugin_schema), field.default_value);
  schema["description"] = field.doc + (field.unit.empty() ? "" : " [" + field.unit + "]");
  Json value = field.required || field.optional ? Json() : to_json(field.default_value);
  if (!value.is_null()) schema["default"] = std::move(value);
  return schema;
}

Json fields_schema(const std::vector<const ParameterFields*>& parts,
                   const PluginSchema& plugin_schema) {
  Json schema{{"type", "object"}, {"properties", Json::object()}, {"additionalProperties", false}};
  for (const ParameterFields* fields : parts) {
    for (const ParameterField& field : *fields) {
      schema["properties"][field.name] = field_schema(field, plugin_schema);
      if (field.required) schema["required"].push_back(field.name);
    }
  }
  return schema;
}

Json plugin_object_schema(const LoadedPlugin& plugin, const PluginSchema& plugin_schema) {
  const PluginFile& file = plugin.file();
  ParameterField name;
  name.name = kPluginKey;
  name.default_value = std::string();
  name.required = true;
  const ParameterFields names{name};
  Json schema{{"title", std::string(name_of(file.kind)) + "/" + file.name},
              {"description", plugin.descriptor().text.summary}};
  schema.update(
      fields_schema({&names, &common_fields(file.kind), &plugin.fields()}, plugin_schema));
  schema["properties"][kPluginKey] = Json{{"const", file.name}};
  return schema;
}

}  // namespace deform
