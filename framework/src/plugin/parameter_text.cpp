#include "plugin/parameter_text.h"

#include <fmt/format.h>

#include "deform/plugin/registry.h"

#include "json/shown.h"
#include "plugin/value_json.h"

namespace deform {
namespace {

template <class... Overloads>
struct Overloaded : Overloads... {
  using Overloads::operator()...;
};
template <class... Overloads>  // clang 14 needs to be told
Overloaded(Overloads...)->Overloaded<Overloads...>;

std::string range_text(const ParameterField& field) {
  std::string text;
  const auto append = [&text](const std::string& part) {
    text += (text.empty() ? "" : ", ") + part;
  };
  const auto number = [](double limit) { return fmt::format("{}", limit); };
  if (field.minimum) append((field.minimum_excluded ? "> " : ">= ") + number(*field.minimum));
  if (field.maximum) append("<= " + number(*field.maximum));
  if (field.may_be_infinite) append("or \"infinity\"");
  for (const std::string& choice : field.choices) append('"' + choice + '"');
  return text;
}

}  // namespace

std::string type_text(const ParameterValue& value) {
  return std::visit(
      Overloaded{
          [](bool) -> std::string { return "true or false"; },
          [](std::int64_t) -> std::string { return "whole number"; },
          [](double) -> std::string { return "number"; },
          [](const std::string&) -> std::string { return "text"; },
          [](const std::filesystem::path&) -> std::string { return "file name"; },
          [](const Vec2&) -> std::string { return "[number, number]"; },
          [](const Vec3&) -> std::string { return "[x, y, z]"; },
          [](const PairWeights&) -> std::string { return "number or [[11, 12], [21, 22]]"; },
          [](const PairWeightsField&) -> std::string {
            return "number, formula or map, or [[11, 12], [21, 22]] of them";
          },
          [](const Field&) -> std::string { return "number, formula or map"; },
          [](const NamedNumbers&) -> std::string { return "object of numbers"; },
          [](const std::vector<double>&) -> std::string { return "list of numbers"; },
          [](const std::vector<std::int64_t>&) -> std::string { return "list of whole numbers"; },
          [](const std::vector<bool>&) -> std::string { return "true, false or a list of them"; },
          [](const std::vector<std::string>&) -> std::string { return "list of texts"; },
          [](const std::vector<Vec3>&) -> std::string { return "list of [x, y, z]"; },
          [](const std::array<std::int64_t, 2>&) -> std::string {
            return "[whole number, whole number]";
          },
          [](const std::array<bool, 2>&) -> std::string { return "true, false or two of them"; },
          [](const TimeProfile&) -> std::string { return "number, ramp, pulse or table"; },
          [](const NodeSelection&) -> std::string { return "selection of nodes"; },
          [](const PluginUse& use) { return std::string(name_of(use.kind)) + " plugin"; },
      },
      value);
}

std::string expectation(const ParameterField& field, const std::string& type) {
  const std::string range = range_text(field);
  const bool is_list = type.starts_with("list");
  std::string text = range.empty()           ? type
                     : field.choices.empty() ? type + ' ' + range
                                             : (is_list ? type + ", " : "") + "one of " + range;
  const bool has_unit = !field.unit.empty() && field.unit != "1";
  return has_unit ? text + " [" + field.unit + "]" : text;
}

std::string expectation(const ParameterField& field) {
  return expectation(field, type_text(field.default_value));
}

ParameterText describe(const ParameterField& field) {
  ParameterText text{type_text(field.default_value), range_text(field), ""};
  if (field.required || field.optional) return text;
  const Json json = to_json(field.default_value);
  if (const auto* use = std::get_if<PluginUse>(&field.default_value)) {
    text.default_value = use->name;
  } else if (!json.is_null()) {
    text.default_value = shown(json);
  }
  return text;
}

}  // namespace deform
