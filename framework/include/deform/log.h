/// Messages to the user and to the run's log.txt; the sink is the program's choice.
#pragma once

#include <string>

#include "deform/export.h"

namespace deform::log {

DEFORM_API void debug(const std::string& message);
DEFORM_API void info(const std::string& message);
DEFORM_API void warn(const std::string& message);

}  // namespace deform::log
