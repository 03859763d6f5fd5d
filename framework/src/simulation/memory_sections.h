/// The memories of several objects in one.
#pragma once

#include <string>

#include "deform/plugin/plugin.h"

namespace deform {

/// Puts what `object` remembers into `memory`, its names prefixed by `section` and a slash.
template <class Object>
void save_section(const Object& object, const std::string& section, Memory& memory) {
  Memory own;
  object.save(own);
  for (const auto& [name, values] : own.entries()) memory.put(section + '/' + name, values);
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

}  // namespace deform
