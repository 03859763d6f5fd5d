#pragma once

#include <array>
#include <optional>
#include <string>
#include <type_traits>
#include <vector>

#include "deform/plugin/declaration.h"

#include "json/json.h"
#include "scene/scene_problems.h"

namespace deform {

/// A value in a scene: the rules for it, and where it is.
struct ValuePlace {
  const ParameterField& field;
  std::string pointer;

  [[nodiscard]] ValuePlace item(std::size_t i) const;
  [[nodiscard]] ValuePlace key(const std::string& name) const;
  /// The same place with rules of its own for the value.
  [[nodiscard]] ValuePlace by(const ParameterField& rules) const { return {rules, pointer}; }
};

/// Reads flags, numbers, texts and arrays of them. Every function returns nothing when the value
/// breaks a rule of its field, which is noted as a problem.
class PlainReader {
 public:
  explicit PlainReader(SceneProblems& problems) : problems_(problems) {}

  template <class T>
  using Maybe = std::optional<T>;

  Maybe<bool> read(const Json& json, const ValuePlace& place, bool by_default);
  Maybe<std::int64_t> read(const Json& json, const ValuePlace& place, std::int64_t by_default);
  Maybe<double> read(const Json& json, const ValuePlace& place, double by_default);
  Maybe<std::string> read(const Json& json, const ValuePlace& place, const std::string& by_default);
  Maybe<Vec2> read(const Json& json, const ValuePlace& place, const Vec2& by_default);
  Maybe<Vec3> read(const Json& json, const ValuePlace& place, const Vec3& by_default);
  /// A number for all pairs, or [[11, 12], [21, 22]] with equal 12 and 21.
  Maybe<PairWeights> read(const Json& json, const ValuePlace& place, const PairWeights& by_default);
  Maybe<NamedNumbers> read(const Json& json, const ValuePlace& place,
                           const NamedNumbers& by_default);
  /// A single flag stands for as many as the default has.
  Maybe<std::vector<bool>> read(const Json& json, const ValuePlace& place,
                                const std::vector<bool>& by_default);
  Maybe<std::array<bool, 2>> read(const Json& json, const ValuePlace& place,
                                  const std::array<bool, 2>& by_default);
  Maybe<std::array<std::int64_t, 2>> read(const Json& json, const ValuePlace& place,
                                          const std::array<std::int64_t, 2>& by_default);
  template <class T>
  Maybe<std::vector<T>> read(const Json& json, const ValuePlace& place,
                             const std::vector<T>& by_default) {
    if (!json.is_array()) return reject(json, place, by_default);
    return items<T>(json, place);
  }

  /// The items of an array.
  template <class T>
  Maybe<std::vector<T>> items(const Json& array, const ValuePlace& place) {
    T example{};
    if constexpr (std::is_same_v<T, Vec3>) example.setZero();
    std::vector<T> values;
    for (std::size_t i = 0; i < array.size(); ++i) {
      if (auto value = read(array[i], place.item(i), example)) values.push_back(std::move(*value));
    }
    if (values.size() != array.size()) return std::nullopt;
    return values;
  }

  /// Notes that a value is not of the type of `example`, or out of its field's range.
  std::nullopt_t reject(const Json& json, const ValuePlace& place, const ParameterValue& example);
  std::nullopt_t reject(const Json& json, const ValuePlace& place, const std::string& expected);
  [[nodiscard]] SceneProblems& problems() { return problems_; }

 private:
  SceneProblems& problems_;
};

/// Notes every key of an object that is not known; `owner` is what messages say does not have it.
void note_unknown_keys(const Json& object, const std::vector<std::string>& known,
                       const std::string& pointer, const std::string& owner,
                       SceneProblems& problems);

}  // namespace deform
