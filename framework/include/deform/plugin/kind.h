/// The kinds of plugin that a scene can name.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

namespace deform {

enum class PluginKind : std::uint8_t {
  surface,
  shape,
  normal,
  energy,
  force,
  constraint,
  collider,
  integrator,
  solver,
  output,
  probe,
};

inline constexpr std::array<std::string_view, 11> kPluginKinds{
    "surface",  "shape",      "normal", "energy", "force", "constraint",
    "collider", "integrator", "solver", "output", "probe"};

[[nodiscard]] constexpr std::string_view name_of(PluginKind kind) {
  return kPluginKinds[static_cast<std::size_t>(kind)];
}

}  // namespace deform
