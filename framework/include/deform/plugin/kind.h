/// The kinds of plugin: one table, from which the framework, the program and the build take theirs.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

/// KIND(name, plural, Interface) of each kind. Scenes, files (`energy-koiter.so`) and messages call
/// a plugin by the name of its kind, [a-z]+; lists of a scene and folders of sources are called by
/// the plural. Plugins of the kind derive from the interface, a class of this namespace, whose
/// `kKind` names the kind in turn. CMake reads these lines, too: framework/cmake/DeformKinds.cmake.
#define DEFORM_PLUGIN_KINDS(KIND)           \
  KIND(surface, surfaces, Surface)          \
  KIND(shape, shapes, Shape)                \
  KIND(normal, normals, NormalEstimator)    \
  KIND(energy, energies, EnergyTerm)        \
  KIND(force, forces, ForceField)           \
  KIND(constraint, constraints, Constraint) \
  KIND(collider, colliders, Collider)       \
  KIND(integrator, integrators, Integrator) \
  KIND(solver, solvers, LinearSolver)       \
  KIND(output, outputs, Output)             \
  KIND(probe, probes, Probe)

namespace deform {

// NOLINTNEXTLINE(bugprone-macro-parentheses): a declaration takes none
#define DEFORM_INTERFACE(name, plural, Interface) class Interface;
DEFORM_PLUGIN_KINDS(DEFORM_INTERFACE)
#undef DEFORM_INTERFACE

#define DEFORM_ENUMERATOR(name, plural, Interface) name,
enum class PluginKind : std::uint8_t { DEFORM_PLUGIN_KINDS(DEFORM_ENUMERATOR) };
#undef DEFORM_ENUMERATOR

#define DEFORM_KIND(name, plural, Interface) PluginKind::name,
inline constexpr std::array kPluginKinds{DEFORM_PLUGIN_KINDS(DEFORM_KIND)};
#undef DEFORM_KIND

/// A value for each kind of plugin.
template <class T>
struct PerKind {
  std::array<T, kPluginKinds.size()> values{};

  [[nodiscard]] constexpr T& operator[](PluginKind kind) {
    return values[static_cast<std::size_t>(kind)];
  }
  [[nodiscard]] constexpr const T& operator[](PluginKind kind) const {
    return values[static_cast<std::size_t>(kind)];
  }
};

#define DEFORM_NAME(name, plural, Interface) #name,
#define DEFORM_PLURAL(name, plural, Interface) #plural,
inline constexpr PerKind<std::string_view> kKindNames{{DEFORM_PLUGIN_KINDS(DEFORM_NAME)}};
inline constexpr PerKind<std::string_view> kKindPlurals{{DEFORM_PLUGIN_KINDS(DEFORM_PLURAL)}};
#undef DEFORM_NAME
#undef DEFORM_PLURAL

[[nodiscard]] constexpr std::string_view name_of(PluginKind kind) { return kKindNames[kind]; }
[[nodiscard]] constexpr std::string_view plural_of(PluginKind kind) { return kKindPlurals[kind]; }

/// The kind of this name, if there is one.
[[nodiscard]] constexpr std::optional<PluginKind> kind_named(std::string_view name) {
  for (const PluginKind kind : kPluginKinds)
    if (name_of(kind) == name) return kind;
  return std::nullopt;
}

/// What make.operator()<Interface>() gives for each kind's interface:
///
///   per_kind<Check>([]<class Interface>() -> Check { return check_as<Interface>; })
template <class T, class Make>
[[nodiscard]] constexpr PerKind<T> per_kind(const Make& make) {
#define DEFORM_MADE(name, plural, Interface) make.template operator()<Interface>(),
  return {{DEFORM_PLUGIN_KINDS(DEFORM_MADE)}};
#undef DEFORM_MADE
}

}  // namespace deform
