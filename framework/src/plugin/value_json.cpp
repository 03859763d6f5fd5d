#include "plugin/value_json.h"

#include <cmath>
#include <vector>

namespace deform {
namespace {

/// One overload for each alternative of ParameterValue, and for what they are made of.
struct Writer {
  static Json json_of(bool value) { return value; }
  static Json json_of(std::int64_t value) { return value; }
  static Json json_of(double value) {
    if (value == kInfinity) return "infinity";
    return std::isfinite(value) ? Json(value) : Json();
  }
  static Json json_of(const std::string& value) { return value; }
  static Json json_of(const std::filesystem::path& value) { return value.string(); }
  static Json json_of(const Vec2& v) { return Json::array({json_of(v.x()), json_of(v.y())}); }
  static Json json_of(const Vec3& v) {
    return Json::array({json_of(v.x()), json_of(v.y()), json_of(v.z())});
  }

  template <class List>
  static Json json_of_list(const List& list) {
    Json items = Json::array();
    for (const auto& item : list) items.push_back(json_of(item));
    return items;
  }
  template <class T>
  static Json json_of(const std::vector<T>& list) {
    return json_of_list(list);
  }
  template <class T>
  static Json json_of(const std::array<T, 2>& pair) {
    return json_of_list(pair);
  }

  static Json json_of(const PairWeights& weights) {
    const auto& [w_11, w_12, w_22] = weights.w;
    if (w_11 == w_12 && w_12 == w_22) return json_of(w_11);
    return Json::array({json_of(Vec2(w_11, w_12)), json_of(Vec2(w_12, w_22))});
  }

  static Json json_of(const Field& field) {
    switch (field.form()) {
      case Field::Form::formula:
        return Json{{"formula", field.source()}};
      case Field::Form::map:
        return Json{{"map", field.source()}};
      case Field::Form::constant:
        break;
    }
    return json_of(field.constant());
  }

  static Json json_of(const PairWeightsField& weights) {
    const Json w_11 = json_of(weights(Pair::p11)), w_12 = json_of(weights(Pair::p12)),
               w_22 = json_of(weights(Pair::p22));
    if (w_11 == w_12 && w_12 == w_22) return w_11;
    return Json::array({Json::array({w_11, w_12}), Json::array({w_12, w_22})});
  }

  static Json json_of(const NamedNumbers& numbers) {
    Json object = Json::object();
    for (const auto& [name, number] : numbers) object[name] = json_of(number);
    return object;
  }

  static Json json_of(const TimeProfile& profile) {
    const auto& points = profile.points;
    const auto times = [&] { return Json::array({points[0].first, points[1].first}); };
    switch (profile.form) {
      case TimeProfile::Form::constant:
        return points.empty() ? 1.0 : points.front().second;
      case TimeProfile::Form::ramp:
        return Json{{"ramp", times()}};
      case TimeProfile::Form::pulse:
        return Json{{"pulse", times()}};
      case TimeProfile::Form::table:
        break;
    }
    Json table = Json::array();
    for (const auto& [time, factor] : points) table.push_back(Json::array({time, factor}));
    return Json{{"table", table}};
  }

  /// One name or number alone, several as a list.
  template <class T>
  static Json one_or_list(const std::vector<T>& items) {
    return items.size() == 1 ? json_of(items.front()) : json_of(items);
  }

  static Json json_of(const NodeSelector& selector) {
    switch (selector.form) {
      case NodeSelector::Form::centre:
        return Json{{"centre", json_of(selector.centre)}, {"radius", selector.radius}};
      case NodeSelector::Form::box: {
        const Json corners = Json::array({json_of(selector.lower), json_of(selector.upper)});
        return Json{{"box", corners}};
      }
      case NodeSelector::Form::boundary:
        return Json{{"boundary", one_or_list(selector.names)}};
      case NodeSelector::Form::corners:
        return Json{{"corners", one_or_list(selector.names)}};
      case NodeSelector::Form::sphere:
        return Json{{"sphere", json_of(selector.place)}, {"radius", selector.radius}};
      case NodeSelector::Form::space: {
        const Json corners = Json::array({json_of(selector.place), json_of(selector.opposite)});
        return Json{{"space", corners}};
      }
      case NodeSelector::Form::nearest:
        return Json{{"nearest", json_of(selector.place)}};
      case NodeSelector::Form::node:
        break;
    }
    return Json{{"node", one_or_list(selector.numbers)}};
  }

  static Json json_of(const NodeSelection& where) {
    if (where.selectors.empty()) return {};
    if (where.selectors.size() == 1) return json_of(where.selectors.front());
    return json_of_list(where.selectors);
  }

  static Json json_of(const PluginUse& use) {
    if (use.name.empty()) return {};
    Json object{{"plugin", use.name}};
    if (use.parameters == nullptr) return object;
    for (const auto& [name, value] : use.parameters->entries()) {
      if (Json json = to_json(value); !json.is_null()) object[name] = std::move(json);
    }
    return object;
  }
};

}  // namespace

Json to_json(const ParameterValue& value) {
  return std::visit([](const auto& v) { return Writer::json_of(v); }, value);
}

}  // namespace deform
