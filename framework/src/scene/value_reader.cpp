#include "scene/value_reader.h"

#include <utility>

#include "deform/error.h"

#include "json/json_pointer.h"
#include "json/shown.h"
#include "plugin/field_schema.h"
#include "plugin/parameter_text.h"
#include "plugin/value_json.h"
#include "scene/field_reader.h"
#include "scene/profile_reader.h"
#include "scene/selection_reader.h"

namespace deform {
namespace {

std::vector<std::string> names_of(const ParameterFields& fields) {
  std::vector<std::string> names;
  for (const ParameterField& field : fields) names.push_back(field.name);
  return names;
}

/// Files of outputs and probes lie in the run directory, all others start from the scene's folder.
bool files_are_the_scenes(PluginKind kind) {
  return kind != PluginKind::output && kind != PluginKind::probe;
}

}  // namespace

std::optional<TimeProfile> ValueReader::read(Json& json, const ValuePlace& place,
                                             const TimeProfile& /*by_default*/) {
  return read_profile(json, place, plain_);
}

std::optional<NodeSelection> ValueReader::read(Json& json, const ValuePlace& place,
                                               const NodeSelection& /*by_default*/) {
  return read_selection(json, place, plain_);
}

std::optional<PluginUse> ValueReader::read(Json& json, const ValuePlace& place,
                                           const PluginUse& by_default) {
  return plugin(json, by_default.kind, place.pointer);
}

std::optional<std::filesystem::path> ValueReader::read(Json& json, const ValuePlace& place,
                                                       const std::filesystem::path& by_default) {
  if (!json.is_string()) return plain_.reject(json, place, ParameterValue(by_default));
  std::filesystem::path file = json.get<std::string>();
  // The completed scene lies in another folder, and must mean the same files there.
  if (resolves_files_ && !file.empty()) {
    try {
      file = scene_file(folder_, file);
    } catch (const InputError& error) {
      problems_.add(place.pointer, error.what());
      return std::nullopt;
    }
    files_.push_back({place.pointer, file});
  }
  json = file.string();
  return file;
}

/// The maps in what was read as a field, or as a matrix of fields.
void ValueReader::note_maps(const Json& json, const std::string& pointer) {
  if (json.is_array()) {
    for (std::size_t i = 0; i < json.size(); ++i) note_maps(json[i], child_pointer(pointer, i));
  } else if (json.is_object() && json.contains("map")) {
    files_.push_back({child_pointer(pointer, "map"), json["map"].get<std::string>()});
  }
}

std::optional<Field> ValueReader::read(Json& json, const ValuePlace& place,
                                       const Field& /*by_default*/) {
  auto field = read_field(json, place, folder_, plain_);
  if (field) note_maps(json, place.pointer);
  return field;
}

std::optional<PairWeightsField> ValueReader::read(Json& json, const ValuePlace& place,
                                                  const PairWeightsField& /*by_default*/) {
  auto weights = read_weights_field(json, place, folder_, plain_);
  if (weights) note_maps(json, place.pointer);
  return weights;
}

std::optional<ParameterValue> ValueReader::value(Json& json, const ValuePlace& place) {
  return std::visit(
      [&]<class T>(const T& by_default) -> std::optional<ParameterValue> {
        auto read_value = read(json, place, by_default);
        if (!read_value) return std::nullopt;
        return ParameterValue(std::in_place_type<T>, std::move(*read_value));
      },
      place.field.default_value);
}

void ValueReader::missing_member(Json& object, const ParameterField& field,
                                 const std::string& pointer, ParameterValues& values) {
  if (field.required) {
    problems_.add(
        pointer, shown(field.name) + " is missing: " + expectation(field) + " (" + field.doc + ")");
    return;
  }
  values.set(field.name, field.default_value);
  if (field.optional) return;
  Json json = to_json(field.default_value);
  if (json.is_null()) return;
  const ValuePlace place{field, child_pointer(pointer, field.name)};
  // A default that stands for "not given" may break the rules for what is given: it stays unsaid.
  // But a plugin that is not found is missing, whoever asks for it.
  const JsonDocument nowhere;
  SceneProblems unsaid(nowhere);
  ValueReader lenient(registry_, folder_, unsaid);
  lenient.resolves_files_ = resolves_files_;
  const bool is_plugin = std::holds_alternative<PluginUse>(field.default_value);
  auto by_default = (is_plugin ? *this : lenient).value(json, place);
  if (!by_default) return;
  values.set(field.name, std::move(*by_default));
  object[field.name] = std::move(json);
}

void ValueReader::member(Json& object, const ParameterField& field, const std::string& pointer,
                         ParameterValues& values) {
  const auto found = object.find(field.name);
  if (found == object.end()) return missing_member(object, field, pointer, values);
  if (auto read_value = value(*found, {field, child_pointer(pointer, field.name)})) {
    values.set(field.name, std::move(*read_value));
  }
}

ParameterValues ValueReader::members(Json& object, const ParameterFields& fields,
                                     const std::string& pointer, const std::string& owner) {
  ParameterValues values;
  note_unknown_keys(object, names_of(fields), pointer, owner, problems_);
  for (const ParameterField& field : fields) member(object, field, pointer, values);
  return values;
}

ParameterValues ValueReader::plugin_members(Json& object, const LoadedPlugin& plugin,
                                            const std::string& pointer) {
  const PluginFile& file = plugin.file();
  ParameterField name;
  name.name = kPluginKey;
  name.default_value = std::string();
  ParameterFields fields{name};
  for (const auto* part : {&common_fields(file.kind), &plugin.fields()}) {
    fields.insert(fields.end(), part->begin(), part->end());
  }
  const bool outer = std::exchange(resolves_files_, files_are_the_scenes(file.kind));
  const std::string owner = std::string(name_of(file.kind)) + " plugin \"" + file.name + '"';
  ParameterValues values = members(object, fields, pointer, owner);
  resolves_files_ = outer;
  return values;
}

PluginUse ValueReader::plugin(Json& json, PluginKind kind, const std::string& pointer) {
  PluginUse use{kind, "", nullptr, pointer};
  const bool is_short = json.is_string();
  if (is_short) json = Json{{kPluginKey, json.get<std::string>()}};
  const std::string what = std::string(name_of(kind)) + " plugin";
  if (!json.is_object()) {
    problems_.add(pointer, "found " + shown(json) + ", expected the " + what +
                               ": its name, or {\"plugin\": name, ...}");
    return use;
  }
  const auto name = json.find(kPluginKey);
  if (name == json.end() || !name->is_string()) {
    problems_.add(pointer, "\"plugin\", the name of the " + what + ", is missing");
    return use;
  }
  use.name = name->get<std::string>();
  try {
    const LoadedPlugin& plugin = registry_.load(kind, use.name);
    use.parameters = std::make_shared<const ParameterValues>(plugin_members(json, plugin, pointer));
  } catch (const InputError& error) {
    const std::string place = is_short ? pointer : child_pointer(pointer, kPluginKey);
    for (const Problem& problem : error.problems())
      problems_.add_missing_plugin(place, problem.message);
  }
  return use;
}

}  // namespace deform
