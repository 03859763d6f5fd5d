/// The memories of several objects in one.
#pragma once

#include <string>

#include "deform/plugin/plugin.h"

namespace deform {

/// Puts what `object` remembers into `memory`, its names prefixed by `section` and a slash.
template <class Object>
void save_section(const Object& object, const std::string& section, Memory& memory) {
  const std::string prefix = section + '/';
  Memory own;
  object.save(own);
  for (const auto& [name, values] : own.entries()) memory.put(prefix + name, values);
}

/// Gives `object` what save_section kept of it.
template <class Object>
void load_section(Object& object, const std::string& section, const Memory& memory) {
  const std::string prefix = section + '/';
  Memory own;
  for (auto it = memory.entries().lower_bound(prefix);
       it != memory.entries().end() && it->first.starts_with(prefix); ++it) {
    own.put(it->first.substr(prefix.size()), it->second);
  }
  object.load(own);
}

/// save_section of a plugin's object; `origin` names it in the PluginFailure that whatever it
/// throws becomes.
void save_plugin(const Plugin& plugin, const std::string& origin, const std::string& section,
                 Memory& memory);

/// load_section of a plugin's object. Throws InputError with the plugin's name when it does not
/// take its memory, PluginFailure for whatever else it throws.
void load_plugin(Plugin& plugin, const std::string& origin, const std::string& section,
                 const Memory& memory);

}  // namespace deform
