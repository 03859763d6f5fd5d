#include "scene/selection_reader.h"

#include <string_view>

namespace deform {
namespace {

constexpr const char* kExpected =
    "{\"centre\": [a1, a2], \"radius\": number}, {\"box\": [[a1, a2], [b1, b2]]}, "
    "{\"boundary\": names}, {\"corners\": names}, {\"node\": numbers}, {\"sphere\": [x, y, z], "
    "\"radius\": number}, {\"space\": [[x, y, z], [x, y, z]]} or {\"nearest\": [x, y, z]}, or a "
    "list "
    "of such objects";

using Form = NodeSelector::Form;

/// Reads the selectors of one value, by rules of their own.
class SelectorReader {
 public:
  explicit SelectorReader(PlainReader& reader) : reader_(reader) {
    length_.unit = "m";
    distance_.unit = "m";
    distance_.minimum = 0;
    number_.minimum = 0;
  }

  std::optional<NodeSelector> read(const Json& json, const ValuePlace& place) {
    if (json.is_object()) {
      if (json.contains("sphere")) return read_sphere(json, place);
      if (json.contains("centre") || json.contains("radius")) return read_centre(json, place);
      if (json.contains("space"))
        return read_alone(json, place, "space", &SelectorReader::read_space);
      if (json.contains("nearest"))
        return read_alone(json, place, "nearest", &SelectorReader::read_nearest);
      if (json.contains("box")) return read_alone(json, place, "box", &SelectorReader::read_box);
      if (json.contains("boundary")) {
        return read_alone(json, place, "boundary", &SelectorReader::read_boundary);
      }
      if (json.contains("corners")) {
        return read_alone(json, place, "corners", &SelectorReader::read_corners);
      }
      if (json.contains("node")) return read_alone(json, place, "node", &SelectorReader::read_node);
    }
    return reader_.reject(json, place, std::string(kExpected));
  }

 private:
  using ReadValue = std::optional<NodeSelector> (SelectorReader::*)(const Json&, const ValuePlace&);

  std::optional<NodeSelector> read_alone(const Json& json, const ValuePlace& place,
                                         const std::string& key, ReadValue read_value) {
    auto selector = (this->*read_value)(json[key], place.key(key));
    note_unknown_keys(json, {key}, place.pointer, "this selector", reader_.problems());
    return selector;
  }

  /// Whether an object has two keys and no other.
  bool is_pair(const Json& json, const ValuePlace& place, const std::vector<std::string>& keys) {
    note_unknown_keys(json, keys, place.pointer, "this selector", reader_.problems());
    for (const std::string& key : keys) {
      if (json.contains(key)) continue;
      reader_.reject(json, place, "a \"" + key + "\" with the other");
      return false;
    }
    return true;
  }

  std::optional<NodeSelector> read_sphere(const Json& json, const ValuePlace& place) {
    if (!is_pair(json, place, {"sphere", "radius"})) return std::nullopt;
    const auto centre = read_place(json["sphere"], place.key("sphere"));
    const auto radius = reader_.read(json["radius"], place.key("radius").by(distance_), 0.0);
    if (!centre || !radius) return std::nullopt;
    NodeSelector selector{.form = Form::sphere};
    selector.place = *centre;
    selector.radius = *radius;
    return selector;
  }

  std::optional<NodeSelector> read_space(const Json& json, const ValuePlace& place) {
    const std::string expected = "[[x, y, z], [x, y, z]], the lower corner first [m]";
    if (!json.is_array() || json.size() != 2) return reader_.reject(json, place, expected);
    const auto lower = read_place(json[0], place.item(0)),
               upper = read_place(json[1], place.item(1));
    if (!lower || !upper) return std::nullopt;
    if ((lower->array() > upper->array()).any()) return reader_.reject(json, place, expected);
    NodeSelector selector{.form = Form::space};
    selector.place = *lower;
    selector.opposite = *upper;
    return selector;
  }

  std::optional<NodeSelector> read_nearest(const Json& json, const ValuePlace& place) {
    const auto point = read_place(json, place);
    if (!point) return std::nullopt;
    NodeSelector selector{.form = Form::nearest};
    selector.place = *point;
    return selector;
  }

  std::optional<Vec3> read_place(const Json& json, const ValuePlace& place) {
    return reader_.read(json, place.by(length_), Vec3(Vec3::Zero()));
  }

  std::optional<NodeSelector> read_centre(const Json& json, const ValuePlace& place) {
    if (!is_pair(json, place, {"centre", "radius"})) return std::nullopt;
    const auto centre = reader_.read(json["centre"], place.key("centre").by(length_), Vec2(0, 0));
    const auto radius = reader_.read(json["radius"], place.key("radius").by(distance_), 0.0);
    if (!centre || !radius) return std::nullopt;
    NodeSelector selector{.form = Form::centre};
    selector.centre = *centre;
    selector.radius = *radius;
    return selector;
  }

  std::optional<NodeSelector> read_box(const Json& json, const ValuePlace& place) {
    const std::string expected = "[[a1, a2], [b1, b2]] with a1 <= b1 and a2 <= b2 [m]";
    if (!json.is_array() || json.size() != 2) return reader_.reject(json, place, expected);
    const auto lower = reader_.read(json[0], place.item(0).by(length_), Vec2(0, 0));
    const auto upper = reader_.read(json[1], place.item(1).by(length_), Vec2(0, 0));
    if (!lower || !upper) return std::nullopt;
    if ((lower->array() > upper->array()).any()) return reader_.reject(json, place, expected);
    NodeSelector selector{.form = Form::box};
    selector.lower = *lower;
    selector.upper = *upper;
    return selector;
  }

  std::optional<NodeSelector> read_boundary(const Json& json, const ValuePlace& place) {
    return read_names(json, place, Form::boundary);
  }
  std::optional<NodeSelector> read_corners(const Json& json, const ValuePlace& place) {
    return read_names(json, place, Form::corners);
  }
  std::optional<NodeSelector> read_names(const Json& json, const ValuePlace& place, Form form) {
    auto names = one_or_several<std::string>(json, place.by(name_), "a name or a list of names");
    if (!names) return std::nullopt;
    NodeSelector selector{.form = form};
    selector.names = std::move(*names);
    return selector;
  }

  std::optional<NodeSelector> read_node(const Json& json, const ValuePlace& place) {
    auto numbers =
        one_or_several<std::int64_t>(json, place.by(number_), "a node's number or a list of them");
    if (!numbers) return std::nullopt;
    NodeSelector selector{.form = Form::node};
    selector.numbers = std::move(*numbers);
    return selector;
  }

  template <class T>
  std::optional<std::vector<T>> one_or_several(const Json& json, const ValuePlace& place,
                                               const std::string& expected) {
    if (json.is_array() && !json.empty()) return reader_.items<T>(json, place);
    if (json.is_structured()) return reader_.reject(json, place, expected);
    auto value = reader_.read(json, place, T{});
    if (!value) return std::nullopt;
    return std::vector<T>{std::move(*value)};
  }

  PlainReader& reader_;
  ParameterField length_, distance_, name_, number_;
};

}  // namespace

std::optional<NodeSelection> read_selection(const Json& json, const ValuePlace& place,
                                            PlainReader& reader) {
  SelectorReader selectors(reader);
  NodeSelection selection;
  selection.pointer = place.pointer;
  if (!json.is_array()) {
    auto selector = selectors.read(json, place);
    if (!selector) return std::nullopt;
    selection.selectors.push_back(std::move(*selector));
    return selection;
  }
  if (json.empty()) return reader.reject(json, place, std::string(kExpected));
  for (std::size_t i = 0; i < json.size(); ++i) {
    if (auto selector = selectors.read(json[i], place.item(i))) {
      selection.selectors.push_back(std::move(*selector));
    }
  }
  if (selection.selectors.size() != json.size()) return std::nullopt;
  return selection;
}

}  // namespace deform
