/// Processes that end within a plugin: a crash, abort(), exit().
#pragma once

#include "deform/export.h"

namespace deform {

/// For a program's first lines. From then on, when the process ends within a plugin by a signal
/// (segmentation fault, stack overflow, abort, …), exit(), quick_exit() or _exit(), stderr says
/// which plugin that was, in which file and what it was doing; a run's manifest gets the status
/// "plugin failed"; and the process ends with ExitCode::plugin_failed. A crash outside of plugins
/// ends it with ExitCode::internal_error. Children that a plugin forks end as they like. Signals'
/// handlers are not set in builds with AddressSanitizer, which has its own.
DEFORM_API void watch_process_end();

/// From now on the program itself ends: exit() is nobody's fault.
DEFORM_API void expect_process_end() noexcept;

}  // namespace deform
