/// Values of parameters: what a scene says, typed; no JSON library's type crosses to a plugin.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <map>
#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "deform/export.h"
#include "deform/plugin/field.h"
#include "deform/plugin/kind.h"
#include "deform/types.h"

namespace deform {

/// Numbers with names that the scene's author chooses.
using NamedNumbers = std::map<std::string, double>;

/// A factor over time: 1 for ever unless said otherwise.
struct DEFORM_API TimeProfile {
  enum class Form : std::uint8_t { constant, ramp, pulse, table };
  Form form = Form::constant;
  /// (time [s], factor) in ascending time. constant: none, or one whose factor holds for ever;
  /// ramp: 0 before the first, 1 after the second, linear between; pulse: 1 from the first until
  /// just before the second, else 0; table: linear between the points, constant outside. Factors of
  /// ramp and pulse do not matter.
  std::vector<std::pair<double, double>> points;

  [[nodiscard]] double operator()(double time) const;
  /// The first corner or jump later than `after` [s]; infinite where there is none. What
  /// Plugin::next_break gives back.
  [[nodiscard]] double next_break(double after) const;
  /// How long it is from `time` to that [s]; what is nearer than rounding of times counts as
  /// passed.
  [[nodiscard]] double until_next_point(double time) const;
};
/// The first of ascending times that is later than `after` [s]; infinite where there is none.
[[nodiscard]] DEFORM_API double first_after(const std::vector<double>& times, double after);

/// One way to select nodes: by their parameters (a1, a2) [m], by their place at rest [m], by name
/// or by number.
struct NodeSelector {
  enum class Form : std::uint8_t { centre, box, boundary, corners, node, sphere, space, nearest };
  Form form = Form::node;
  Vec2 centre = Vec2::Zero();  ///< centre: maximum norm …
  double radius = 0;           ///< … at most this [m]
  Vec2 lower = Vec2::Zero();   ///< box, closed
  Vec2 upper = Vec2::Zero();
  std::vector<std::string> names;     ///< boundary or corners: what the surface calls them
  std::vector<std::int64_t> numbers;  ///< node: numbers
  Vec3 place = Vec3::Zero();     ///< of the rest surface: sphere's centre (with `radius`), lower
                                 ///< corner of space's box, what the nearest node is near to
  Vec3 opposite = Vec3::Zero();  ///< upper corner of space's box
};
/// A union of selectors.
struct NodeSelection {
  std::vector<NodeSelector> selectors;
  std::string pointer{};  ///< where the scene says so
};

class ParameterValues;

/// A plugin that a parameter names, with its parameters (already checked).
struct PluginUse {
  PluginKind kind = PluginKind::normal;
  std::string name;
  std::shared_ptr<const ParameterValues> parameters;  ///< null: all defaults
  std::string pointer;                                ///< where the scene says so
};
/// Throws InputError, with the use's pointer, when it names a plugin of another kind.
DEFORM_API void require_kind(const PluginUse& use, PluginKind kind);

using ParameterValue =
    std::variant<bool, std::int64_t, double, std::string, Vec2, Vec3, PairWeights,
                 std::vector<double>, std::vector<std::int64_t>, std::vector<bool>,
                 std::vector<std::string>, std::array<std::int64_t, 2>, std::array<bool, 2>,
                 std::vector<Vec3>, TimeProfile, NodeSelection, PluginUse, std::filesystem::path,
                 NamedNumbers, Field, PairWeightsField>;

/// The values of one plugin's parameters, defaults filled in.
class DEFORM_API ParameterValues {
 public:
  ParameterValues();
  ~ParameterValues();
  ParameterValues(const ParameterValues& other);
  ParameterValues(ParameterValues&& other) noexcept;
  ParameterValues& operator=(const ParameterValues& other);
  ParameterValues& operator=(ParameterValues&& other) noexcept;

  void set(const std::string& name, ParameterValue value);
  [[nodiscard]] bool has(const std::string& name) const;
  /// Throws std::out_of_range where there is none.
  [[nodiscard]] const ParameterValue& at(const std::string& name) const;
  template <class T>
  [[nodiscard]] const T& get(const std::string& name) const {
    return std::get<T>(at(name));
  }
  [[nodiscard]] const std::map<std::string, ParameterValue>& entries() const { return values_; }

 private:
  std::map<std::string, ParameterValue> values_;
};

inline constexpr double kInfinity = std::numeric_limits<double>::infinity();

}  // namespace deform
