/// What the user hears of an exception.
#pragma once

namespace deform::app {

/// Called while an exception is handled: prints it to stderr, every problem of bad input on a line
/// of its own. Returns the program's exit code.
[[nodiscard]] int report_current_error();

/// Writes what is left of standard output. Returns `code`, or, where that says "done" although not
/// everything could be written, the one of an internal error, and prints the reason.
[[nodiscard]] int finish_output(int code);

}  // namespace deform::app
