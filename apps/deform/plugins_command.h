/// deform plugins
#pragma once

#include <string>

#include "deform/plugin/registry.h"

/// `deform plugins [KIND | KIND/NAME]`: prints all plugins (of a kind) and the folders searched; of
/// a single one what it is and its parameters. Returns the exit code. Throws InputError when there
/// is no such kind or plugin, or the plugin does not load.
int list_plugins(const deform::PluginRegistry& registry, const std::string& which = "");
