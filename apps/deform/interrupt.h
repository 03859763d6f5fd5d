/// Ctrl-C, and what else comes as a signal.
#pragma once

#include <atomic>

namespace deform::app {

/// For the program's first lines: limits on the size of files are errors of writing, not signals,
/// and children can be waited for.
void prepare_signals();

/// Makes the first SIGINT, SIGTERM or SIGHUP set the flag that is returned, and the second one,
/// 0.3 s later or more, end the program at once with 130. Those that the program was begun to
/// ignore (nohup) it goes on to ignore.
const std::atomic<bool>& watch_interrupts();

/// From now on the first one ends the program, for what nobody needs to be whole. Returns whether
/// none has come yet.
[[nodiscard]] bool end_when_interrupted();

}  // namespace deform::app
