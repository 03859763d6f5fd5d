/// Ctrl-C.
#pragma once

#include <atomic>

namespace deform::app {

/// Makes the first SIGINT or SIGTERM set the flag that is returned, and the second one end the
/// program at once with 130. Limits on the size of files are errors of writing, not signals.
const std::atomic<bool>& watch_interrupts();

}  // namespace deform::app
