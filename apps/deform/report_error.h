/// What the user hears of an exception.
#pragma once

namespace deform::app {

/// Called while an exception is handled: prints it to stderr, every problem of bad input on a line
/// of its own. Returns the program's exit code.
[[nodiscard]] int report_current_error();

}  // namespace deform::app
