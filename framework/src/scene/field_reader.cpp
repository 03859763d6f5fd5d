#include "scene/field_reader.h"

#include "deform/error.h"

#include "plugin/parameter_text.h"

namespace deform {
namespace {

bool is_field_object(const Json& json) {
  if (!json.is_object() || json.size() != 1 || !json.begin()->is_string()) return false;
  return json.begin().key() == "formula" || json.begin().key() == "map";
}

FieldRules rules_of(const ValuePlace& place) {
  const ParameterField& field = place.field;
  return {place.pointer, field.unit, field.minimum, field.maximum, field.minimum_excluded};
}

Field field_of(Json& json, const ValuePlace& place, const std::filesystem::path& folder) {
  const auto text = json.begin()->get<std::string>();
  if (json.begin().key() == "formula") return Field::formula(text, rules_of(place));
  // The completed scene lies in another folder, and must mean the same file there.
  const std::filesystem::path file = scene_file(folder, text);
  *json.begin() = file.string();
  return Field::map(file, rules_of(place));
}

}  // namespace

std::filesystem::path scene_file(const std::filesystem::path& folder,
                                 const std::filesystem::path& file) {
  std::filesystem::path absolute = (folder / file).lexically_normal();
  if (!is_utf8(absolute.string()))
    throw InputError(file.string() +
                     ": lies in a folder whose name is not UTF-8, which a scene cannot say");
  return absolute;
}

std::optional<Field> read_field(Json& json, const ValuePlace& place,
                                const std::filesystem::path& folder, PlainReader& reader) {
  if (json.is_number() || json.is_string()) {  // "infinity", where it may be
    if (const auto number = reader.read(json, place, 0.0)) return Field(*number);
    return std::nullopt;
  }
  if (!is_field_object(json)) return reader.reject(json, place, ParameterValue(Field()));
  const ValuePlace inside = place.key(json.begin().key());
  try {
    return field_of(json, place, folder);
  } catch (const InputError& error) {
    if (!reader.problems().takes_no_more()) reader.problems().add(inside.pointer, error.what());
    return std::nullopt;
  }
}

std::optional<PairWeightsField> read_weights_field(Json& json, const ValuePlace& place,
                                                   const std::filesystem::path& folder,
                                                   PlainReader& reader) {
  if (!json.is_array()) {
    const bool may_be_one = json.is_number() || json.is_string() || is_field_object(json);
    if (!may_be_one) return reader.reject(json, place, ParameterValue(PairWeightsField()));
    const auto all = read_field(json, place, folder, reader);
    return all ? std::optional(PairWeightsField::all(*all)) : std::nullopt;
  }
  const auto is_pair = [](const Json& value) { return value.is_array() && value.size() == 2; };
  if (!is_pair(json) || !is_pair(json[0]) || !is_pair(json[1]))
    return reader.reject(json, place, ParameterValue(PairWeightsField()));
  const bool symmetric = json[0][1] == json[1][0];
  std::array<std::optional<Field>, 4> fields;
  for (const std::size_t i : {0U, 1U})
    for (const std::size_t j : {0U, 1U})
      fields.at(2 * i + j) = read_field(json[i][j], place.item(i).item(j), folder, reader);
  if (!fields[0] || !fields[1] || !fields[2] || !fields[3]) return std::nullopt;
  if (!symmetric)
    return reader.reject(json, place, "a symmetric [[11, 12], [21, 22]]: 12 must equal 21");
  return PairWeightsField({*fields[0], *fields[1], *fields[3]});
}

}  // namespace deform
