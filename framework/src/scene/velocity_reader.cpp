#include "scene/velocity_reader.h"

#include <algorithm>

#include "deform/error.h"

#include "json/json_pointer.h"
#include "plugin/field_schema.h"
#include "plugin/parameter_text.h"
#include "plugin/value_json.h"

namespace deform {
namespace {

constexpr std::size_t kComponents = 3;
constexpr const char* kVector = "[x, y, z] of numbers and formulas";

const ParameterField& field_named(const ParameterFields& fields, const char* name) {
  return *std::ranges::find(fields, name, &ParameterField::name);
}

std::optional<Field> read_component(const Json& json, const ValuePlace& place,
                                    PlainReader& reader) {
  if (json.is_number()) {
    if (const auto number = reader.read(json, place, 0.0)) return Field(*number);
    return std::nullopt;
  }
  if (!json.is_string())
    return reader.reject(json, place, expectation(place.field, "number or formula"));
  try {
    FieldRules rules;
    rules.pointer = place.pointer;
    rules.unit = place.field.unit;
    return Field::formula(json.get<std::string>(), std::move(rules));
  } catch (const InputError& error) {
    if (!reader.problems().takes_no_more()) reader.problems().add(place.pointer, error.what());
    return std::nullopt;
  }
}

std::optional<std::array<Field, kComponents>> read_linear(const Json& json, const ValuePlace& place,
                                                          PlainReader& reader) {
  if (!json.is_array() || json.size() != kComponents)
    return reader.reject(json, place, expectation(place.field, kVector));
  std::array<Field, kComponents> linear;
  bool all = true;
  for (std::size_t c = 0; c < kComponents; ++c) {
    auto component = read_component(json[c], place.item(c), reader);
    all = all && component;
    if (component) linear.at(c) = std::move(*component);
  }
  return all ? std::optional(std::move(linear)) : std::nullopt;
}

/// What is not given, into the object; behind what is there.
void complete(Json& object, const ParameterField& field) {
  if (!object.contains(field.name)) object[field.name] = to_json(field.default_value);
}

std::optional<InitialVelocity> read_object(Json& object, const ParameterFields& fields,
                                           const std::string& pointer, PlainReader& reader) {
  std::vector<std::string> names;
  for (const ParameterField& field : fields) names.push_back(field.name);
  note_unknown_keys(object, names, pointer, "velocity", reader.problems());
  const auto place = [&](const char* name) {
    return ValuePlace{field_named(fields, name), child_pointer(pointer, name)};
  };
  complete(object, field_named(fields, kLinear));
  complete(object, field_named(fields, kSpin));
  auto linear = read_linear(object[kLinear], place(kLinear), reader);
  const auto spin = reader.read(object[kSpin], place(kSpin), Vec3(Vec3::Zero()));
  InitialVelocity velocity;
  if (object.contains(kAbout)) {
    velocity.about = reader.read(object[kAbout], place(kAbout), Vec3(Vec3::Zero()));
    if (!velocity.about) return std::nullopt;
  }
  if (!linear || !spin) return std::nullopt;
  velocity.linear = std::move(*linear);
  velocity.spin = *spin;
  return velocity;
}

}  // namespace

std::optional<InitialVelocity> read_velocity(Json& json, const ParameterFields& fields,
                                             const std::string& pointer, PlainReader& reader) {
  if (json.is_object()) return read_object(json, fields, pointer, reader);
  const ValuePlace place{field_named(fields, kLinear), pointer};
  if (!json.is_array()) {
    return reader.reject(json, place,
                         expectation(place.field, kVector) + R"(, or {"linear", "spin", "about"})");
  }
  auto linear = read_linear(json, place, reader);
  if (!linear) return std::nullopt;
  InitialVelocity velocity;
  velocity.linear = std::move(*linear);
  return velocity;
}

Json velocity_member_schema(const ParameterField& field) {
  Json schema = field_schema(field, {});
  if (field.name == kLinear) {
    schema["items"] = Json::object();
    schema["items"]["anyOf"] = Json::array({Json{{"type", "number"}}, Json{{"type", "string"}}});
  } else if (field.name == kAbout) {
    schema.erase("default");  // it is no place that could be said
  }
  return schema;
}

Json velocity_schema(const ParameterFields& fields) {
  const Json list = velocity_member_schema(field_named(fields, kLinear));
  Json object{{"type", "object"}, {"properties", Json::object()}, {"additionalProperties", false}};
  for (const ParameterField& field : fields)
    object["properties"][field.name] = velocity_member_schema(field);
  Json schema = Json::object();
  schema["anyOf"] = Json::array({list, object});
  schema["description"] = "of every free node at first: linear + spin × (r − about)";
  schema["default"] = list["default"];
  return schema;
}

}  // namespace deform
