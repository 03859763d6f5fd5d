/// Makes built-in plugins as the framework does: from their libraries.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "deform/plugin/registry.h"
#include "deform/plugin/setup.h"

namespace deform::test {

/// A setup without surface, in which no plugin can make another.
inline Setup bare_setup() { return Setup(nullptr); }

/// The built-in plugin of the interface's kind; parameters that `values` does not have keep their
/// defaults.
template <class Interface>
std::shared_ptr<Interface> make_builtin(const std::string& name, const ParameterValues& values = {},
                                        const Setup& setup = bare_setup()) {
  static const PluginRegistry registry(std::vector<std::filesystem::path>{DEFORM_PLUGINS});
  return std::dynamic_pointer_cast<Interface>(
      registry.load(Interface::kKind, name).create(values, setup));
}

/// Values from a list of names and values.
inline ParameterValues parameters(
    std::initializer_list<std::pair<std::string, ParameterValue>> list) {
  ParameterValues values;
  for (const auto& [name, value] : list) values.set(name, value);
  return values;
}

}  // namespace deform::test
