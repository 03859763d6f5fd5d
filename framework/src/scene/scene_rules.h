#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>

#include "deform/plugin/declaration.h"

namespace deform {

/// What stands at a key of a scene, and the rules for it.
struct SceneSection {
  enum class Form {
    note,      ///< text for programs that edit scenes; not kept
    value,     ///< one value, by the only field
    object,    ///< an object with the fields
    velocity,  ///< what read_velocity reads, by the fields
    plugin,    ///< a plugin of the kind
    plugins,   ///< an array of plugins of the kind
    shadows,   ///< the same, of plugins that take no part in the run
    variants,  ///< names of variants, and what they replace
  };
  std::string_view name;
  Form form;
  PluginKind kind{};                             ///< of plugin, plugins and shadows
  bool required = false;                         ///< of plugin; a value's field says it itself
  const ParameterFields& (*fields)() = nullptr;  ///< of value, object and velocity
  bool of_run = true;  ///< part of what is run: not so what only a comparison looks at

  [[nodiscard]] std::string key() const { return std::string(name); }
  [[nodiscard]] std::string pointer() const { return '/' + key(); }
  /// Whether it names all plugins of its kind that take part in the run, but for those that stand
  /// in parameters.
  [[nodiscard]] constexpr bool names_parts() const {
    return form == Form::plugin || form == Form::plugins;
  }
};

/// More than these nobody writes by hand, and a program that does has made a mistake.
inline constexpr std::size_t kMostPlugins = 1000;  ///< in one list
inline constexpr std::size_t kMostVariants = 1000;
inline constexpr std::size_t kMostShadows = 1000;  ///< shadows times energy terms that they are of

/// Choices of the material's `mass`.
inline constexpr const char* kRest = "rest";
inline constexpr const char* kParameters = "parameters";

/// All keys of a scene, in the order in which a completed scene has them. The only place that says
/// which there are.
std::span<const SceneSection> scene_sections();

/// The one that names the parts of a kind; null where only parameters of other plugins do.
const SceneSection* section_of(PluginKind kind);

}  // namespace deform
