#include "scene/profile_reader.h"

#include <algorithm>
#include <map>

namespace deform {
namespace {

constexpr const char* kExpected =
    R"(a number, {"ramp": [t0, t1]}, {"pulse": [t0, t1]} or {"table": [[t, factor], ...]})";

using Points = std::vector<std::pair<double, double>>;

/// Times of a ramp or pulse, and the factors that it has there.
std::optional<Points> read_times(const Json& json, const ValuePlace& place, PlainReader& reader) {
  const auto times = reader.read(json, place, Vec2(0, 0));
  if (!times) return std::nullopt;
  return Points{{(*times)[0], 0}, {(*times)[1], 1}};
}

std::optional<Points> read_table(const Json& json, const ValuePlace& place, PlainReader& reader) {
  if (!json.is_array() || json.empty()) {
    return reader.reject(json, place, std::string("a list of [time, factor], at least one"));
  }
  Points points;
  for (std::size_t i = 0; i < json.size(); ++i) {
    if (const auto point = reader.read(json[i], place.item(i), Vec2(0, 0))) {
      points.emplace_back((*point)[0], (*point)[1]);
    }
  }
  if (points.size() != json.size()) return std::nullopt;
  return points;
}

bool are_ascending(const Points& points) {
  return std::adjacent_find(points.begin(), points.end(), [](const auto& a, const auto& b) {
           return a.first >= b.first;
         }) == points.end();
}

}  // namespace

std::optional<TimeProfile> read_profile(const Json& json, const ValuePlace& where,
                                        PlainReader& reader) {
  using Form = TimeProfile::Form;
  static const ParameterField no_range;
  static const std::map<std::string, Form> forms{
      {"ramp", Form::ramp}, {"pulse", Form::pulse}, {"table", Form::table}};
  const ValuePlace place = where.by(no_range);
  if (json.is_number()) return TimeProfile{Form::constant, {{0, json.get<double>()}}};
  if (!json.is_object() || json.size() != 1 || !forms.contains(json.begin().key())) {
    return reader.reject(json, place, std::string(kExpected));
  }
  const std::string& key = json.begin().key();
  const Json& value = *json.begin();
  const Form form = forms.at(key);
  auto points = form == Form::table ? read_table(value, place.key(key), reader)
                                    : read_times(value, place.key(key), reader);
  if (!points) return std::nullopt;
  if (!are_ascending(*points)) {
    return reader.reject(value, place.key(key), std::string("ascending times"));
  }
  return TimeProfile{form, std::move(*points)};
}

}  // namespace deform
