#include "scene/plain_reader.h"

#include <algorithm>
#include <cmath>

#include "json/json_pointer.h"
#include "json/shown.h"
#include "plugin/parameter_text.h"
#include "text/nearest_name.h"

namespace deform {
namespace {

bool in_range(double value, const ParameterField& field) {
  if (field.minimum && value < *field.minimum) return false;
  if (field.minimum && field.minimum_excluded && value == *field.minimum) return false;
  return !field.maximum || value <= *field.maximum;
}

bool is_array_of(const Json& json, std::size_t size) {
  return json.is_array() && json.size() == size;
}

/// A whole number, also when it is written like 2.0 (up to where doubles hold all of them).
std::optional<std::int64_t> whole_number(const Json& json) {
  if (json.is_number_integer()) return json.get<std::int64_t>();
  if (!json.is_number_float()) return std::nullopt;
  constexpr double kMost = 9007199254740992.0;  // 2^53
  const double value = json.get<double>();
  if (std::trunc(value) != value || std::abs(value) > kMost) return std::nullopt;
  return static_cast<std::int64_t>(value);
}

}  // namespace

ValuePlace ValuePlace::item(std::size_t i) const { return {field, child_pointer(pointer, i)}; }
ValuePlace ValuePlace::key(const std::string& name) const {
  return {field, child_pointer(pointer, name)};
}

std::nullopt_t PlainReader::reject(const Json& json, const ValuePlace& place,
                                   const ParameterValue& example) {
  return reject(json, place, expectation(place.field, type_text(example)));
}

std::nullopt_t PlainReader::reject(const Json& json, const ValuePlace& place,
                                   const std::string& expected) {
  if (!problems_.takes_no_more()) {
    problems_.add(place.pointer, "found " + shown(json) + ", expected " + expected);
  }
  return std::nullopt;
}

std::optional<bool> PlainReader::read(const Json& json, const ValuePlace& place, bool by_default) {
  if (!json.is_boolean()) return reject(json, place, ParameterValue(by_default));
  return json.get<bool>();
}

std::optional<std::int64_t> PlainReader::read(const Json& json, const ValuePlace& place,
                                              std::int64_t by_default) {
  const auto value = whole_number(json);
  if (!value || !in_range(static_cast<double>(*value), place.field)) {
    return reject(json, place, ParameterValue(by_default));
  }
  return value;
}

std::optional<double> PlainReader::read(const Json& json, const ValuePlace& place,
                                        double by_default) {
  const bool infinite = place.field.may_be_infinite && json == "infinity";
  if (!json.is_number() && !infinite) return reject(json, place, ParameterValue(by_default));
  const double value = infinite ? kInfinity : json.get<double>();
  if (!infinite && !in_range(value, place.field)) {
    return reject(json, place, ParameterValue(by_default));
  }
  return value;
}

std::optional<std::string> PlainReader::read(const Json& json, const ValuePlace& place,
                                             const std::string& by_default) {
  if (!json.is_string()) return reject(json, place, ParameterValue(by_default));
  auto text = json.get<std::string>();
  const auto& choices = place.field.choices;
  if (choices.empty() || std::find(choices.begin(), choices.end(), text) != choices.end()) {
    return text;
  }
  std::string expected = expectation(place.field);
  if (const auto nearest = nearest_name(text, choices)) {
    expected += "; did you mean \"" + *nearest + "\"?";
  }
  return reject(json, place, expected);
}

std::optional<Vec2> PlainReader::read(const Json& json, const ValuePlace& place,
                                      const Vec2& by_default) {
  if (!is_array_of(json, 2)) return reject(json, place, ParameterValue(by_default));
  const auto v = items<double>(json, place);
  if (!v) return std::nullopt;
  return Vec2((*v)[0], (*v)[1]);
}

std::optional<Vec3> PlainReader::read(const Json& json, const ValuePlace& place,
                                      const Vec3& by_default) {
  if (!is_array_of(json, 3)) return reject(json, place, ParameterValue(by_default));
  const auto v = items<double>(json, place);
  if (!v) return std::nullopt;
  return Vec3((*v)[0], (*v)[1], (*v)[2]);
}

std::optional<PairWeights> PlainReader::read(const Json& json, const ValuePlace& place,
                                             const PairWeights& by_default) {
  if (!json.is_array()) {
    const bool may_be_number = json.is_number() || json.is_string();
    if (!may_be_number) return reject(json, place, ParameterValue(by_default));
    const auto all = read(json, place, 0.0);
    return all ? std::optional(PairWeights::all(*all)) : std::nullopt;
  }
  if (!is_array_of(json, 2)) return reject(json, place, ParameterValue(by_default));
  const auto first = read(json[0], place.item(0), Vec2(0, 0));
  const auto second = read(json[1], place.item(1), Vec2(0, 0));
  if (!first || !second) return std::nullopt;
  if ((*first)[1] != (*second)[0]) {
    return reject(json, place, "a symmetric [[11, 12], [21, 22]]: 12 must equal 21");
  }
  return PairWeights{{(*first)[0], (*first)[1], (*second)[1]}};
}

std::optional<NamedNumbers> PlainReader::read(const Json& json, const ValuePlace& place,
                                              const NamedNumbers& by_default) {
  if (!json.is_object()) return reject(json, place, ParameterValue(by_default));
  NamedNumbers numbers;
  for (const auto& [name, number] : json.items())
    if (const auto value = read(number, place.key(name), 0.0)) numbers[name] = *value;
  if (numbers.size() != json.size()) return std::nullopt;
  return numbers;
}

std::optional<std::vector<bool>> PlainReader::read(const Json& json, const ValuePlace& place,
                                                   const std::vector<bool>& by_default) {
  if (json.is_boolean()) {
    return std::vector<bool>(std::max<std::size_t>(by_default.size(), 1), json.get<bool>());
  }
  if (!json.is_array()) return reject(json, place, ParameterValue(by_default));
  return items<bool>(json, place);
}

std::optional<std::array<bool, 2>> PlainReader::read(const Json& json, const ValuePlace& place,
                                                     const std::array<bool, 2>& by_default) {
  if (json.is_boolean()) return std::array{json.get<bool>(), json.get<bool>()};
  if (!is_array_of(json, 2)) return reject(json, place, ParameterValue(by_default));
  const auto pair = items<bool>(json, place);
  if (!pair) return std::nullopt;
  return std::array<bool, 2>{(*pair)[0], (*pair)[1]};
}

std::optional<std::array<std::int64_t, 2>> PlainReader::read(
    const Json& json, const ValuePlace& place, const std::array<std::int64_t, 2>& by_default) {
  if (!is_array_of(json, 2)) return reject(json, place, ParameterValue(by_default));
  const auto pair = items<std::int64_t>(json, place);
  if (!pair) return std::nullopt;
  return std::array{(*pair)[0], (*pair)[1]};
}

void note_unknown_keys(const Json& object, const std::vector<std::string>& known,
                       const std::string& pointer, const std::string& owner,
                       SceneProblems& problems) {
  for (const auto& member : object.items()) {
    const std::string& key = member.key();
    if (std::find(known.begin(), known.end(), key) != known.end()) continue;
    if (problems.takes_no_more()) continue;
    const std::string rule = owner + " has no " + shown(key) + did_you_mean(key, known);
    problems.add_unknown_key(child_pointer(pointer, key), rule);
  }
}

}  // namespace deform
