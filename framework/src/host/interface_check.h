#pragma once

#include <memory>
#include <string>

#include "deform/plugin/kind.h"
#include "deform/plugin/plugin.h"

namespace deform {

/// The object that the plugin `origin` made, which has its kind's interface: checked here, once for
/// all who use it, and guarded where other plugins will. Throws PluginFailure when it has another.
std::shared_ptr<Plugin> through_interface(std::shared_ptr<Plugin> object, PluginKind kind,
                                          const std::string& origin);

}  // namespace deform
