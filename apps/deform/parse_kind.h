#pragma once

#include <string>

#include "deform/plugin/kind.h"

namespace deform::app {

/// The kind that a command line names. Throws InputError, with all kinds, when there is none.
[[nodiscard]] PluginKind parse_kind(const std::string& text);

}  // namespace deform::app
